//! Any bytes as a saved distance field.
#![no_main]

#[path = "../../tests/properties/field.rs"]
mod field;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    field::check_field(bytes).expect("it is refused, or sound");
});
