//! Reports: tables, JSON, plots and the HTML page. Nothing here but `compare` decides anything; it shows what was
//! decided.

pub mod compare;
pub mod contact_sheet;
pub mod figures;
pub mod html;
pub mod json;
pub mod plot;
pub mod probe;
pub mod save;
pub mod table;
pub mod text;

use crate::bsdf::Bsdf;
use crate::validate::Sheet;

/// A model with its sheet, under the name that the user gave it.
#[derive(Debug)]
pub struct Judged {
    /// The SUBJECT as it was typed.
    pub name: String,
    /// The model.
    pub bsdf: Box<dyn Bsdf>,
    /// Its sheet.
    pub sheet: Sheet,
}
