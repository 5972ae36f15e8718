//! Checks of `[contact]`.

use super::body::Body;
use super::file::File;
use super::problem::Problem;
use super::values::positive;
use crate::cloth::contact::{self, Contact, ContactFault, LARGEST_THICKNESS};

/// Gives the fabric of a structure its contact, if the case asks for it.
pub(super) fn check(file: &File, body: &mut Body) -> Result<(), Problem> {
    const KEY: &str = "contact.thickness_m";
    let Some(written) = &file.contact else {
        return Ok(());
    };
    if let Some(every) = file.coupling.as_ref().and_then(|c| c.structure_every)
        && every != 1
    {
        return Err(Problem::new(
            "coupling.structure_every",
            format!(
                "coupling.structure_every = {every} with [contact]: between its solves fabric would pass through itself"
            ),
            "give coupling.structure_every = 1, or remove [contact]",
        ));
    }
    let contact = Contact {
        thickness_m: positive(KEY, written.thickness_m)?,
    };
    contact::check(&body.structure, contact).map_err(|fault| match fault {
        ContactFault::TooThick { altitude_m, .. } => Problem::new(
            KEY,
            format!("{KEY} = {}: {fault}", contact.thickness_m),
            format!(
                "give at most {:.2e} m, or use a mesh without such a small triangle (numbers count from 0)",
                LARGEST_THICKNESS * altitude_m
            ),
        ),
        ContactFault::Crossing { .. } | ContactFault::Touching { .. } => Problem::new(
            "contact",
            format!("the fabric cannot meet itself: at the start {fault}"),
            "begin with fabric that is apart everywhere, if only by little (a wider folding, another mesh), or remove [contact] (numbers \
             count from 0)",
        ),
    })?;
    body.structure.contact = Some(contact);
    Ok(())
}
