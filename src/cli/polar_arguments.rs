//! Arguments of `ripstop polar`.

use std::path::PathBuf;

use clap::Args;

use super::case_arguments::CaseArguments;
use crate::sweep::Vary;

#[derive(Debug, Args)]
pub(super) struct PolarArguments {
    #[command(flatten)]
    pub(super) case: CaseArguments,
    /// Angles of attack of a wing by itself [°].
    #[arg(long, value_name = "FROM,TO,STEP", allow_hyphen_values = true)]
    pub(super) angle: Option<String>,
    /// Lengths by which the brakes are pulled [m]: one trim each.
    #[arg(long, value_name = "M,M,…", allow_hyphen_values = true)]
    pub(super) brake: Option<String>,
    /// Shares of the speed bar's travel, 0 to 1: one trim each; the plan needs [structure.wing.speed_bar].
    #[arg(long, value_name = "SHARE,SHARE,…", allow_hyphen_values = true)]
    pub(super) bar: Option<String>,
    /// Masses of the pilot, harness and all [kg]: one trim each.
    #[arg(long, value_name = "KG,KG,…", allow_hyphen_values = true)]
    pub(super) mass: Option<String>,
    /// Any other key and its values, as `ripstop sweep` takes them; may be given several times.
    #[arg(long, value_name = "KEY.PATH=A,B,C")]
    pub(super) vary: Vec<Vary>,
    /// Folder for the table, the charts and the page.
    #[arg(long, default_value = "polar")]
    pub(super) out: PathBuf,
    /// Replace what the folder holds: the polar of a wing by itself, or trims of another case.
    #[arg(long)]
    pub(super) overwrite: bool,
}
