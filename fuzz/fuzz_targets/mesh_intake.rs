//! Any bytes as a mesh that becomes a cloth.
#![no_main]

#[path = "../../tests/properties/decode.rs"]
mod decode;
#[path = "../../tests/properties/soup.rs"]
mod soup;

use bevy::app::App;
use std::cell::RefCell;

thread_local! {
    static APP: RefCell<App> = RefCell::new(soup::app());
}

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    APP.with_borrow_mut(|app| soup::check_soup(app, &decode::soup_of(bytes)))
        .expect("it is refused, or sound");
});
