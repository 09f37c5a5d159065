#![no_main]

libfuzzer_sys::fuzz_target!(|input: &[u8]| {
    lafet_verify::fuzz::Target::by_name("drawing").expect("a target").run(input);
});
