//! `ripstop polar CASE.toml`: forces of a wing over angle of attack, brake, speed bar and mass.

use super::bare_polar;
use super::exit;
use super::failure::Failure;
use super::polar_arguments::PolarArguments;
use super::trim_polar;

pub(super) fn polar(arguments: &PolarArguments) -> Result<u8, Failure> {
    let mut angles = Vec::new();
    if let Some(text) = &arguments.angle {
        let numbers = text.split(',').map(|word| word.trim().parse::<f64>());
        let numbers: Vec<f64> = numbers.filter_map(Result::ok).collect();
        let [from, to, step] = numbers[..] else {
            return Err(not_angles(text));
        };
        if numbers.iter().any(|number| !number.is_finite()) || text.split(',').count() != 3 {
            return Err(not_angles(text));
        }
        angles.push(format!("aero.wing.angles_deg=[{from:?}, {to:?}, {step:?}]"));
    }
    let case = arguments.case.load(&[])?;
    let trims = [&arguments.brake, &arguments.bar, &arguments.mass];
    if case.scene.bare_wing.is_some() {
        if trims.iter().any(|list| list.is_some()) || !arguments.vary.is_empty() {
            return Err(Failure::Other(
                exit::BAD_CASE,
                "--brake, --bar, --mass and --vary are for a wing of fabric in trim; this case holds a wing by itself, which has --angle".to_owned(),
            ));
        }
        arguments.case.refuse_device_of_bare_wing(&case)?;
        return bare_polar::polar(arguments, &arguments.case.load(&angles)?);
    }
    trim_polar::polar(arguments, &case)
}

fn not_angles(text: &str) -> Failure {
    Failure::Other(
        exit::BAD_CASE,
        format!(
            "--angle {text} is not FROM,TO,STEP: give three numbers in degrees, as --angle -4,20,1"
        ),
    )
}
