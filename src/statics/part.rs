//! A part of a phase without time.

/// How far something has come.
pub(super) enum Ended<T> {
    NotYet,
    With(T),
    Interrupted,
}
