//! The playground for a web page, without glue that has to be generated.
//!
//! The page writes a command (JSON, UTF-8) to `buffer(len)`, calls `call()`, and reads as many
//! bytes as that returns from `answer()`. After a trap, `message()` and `message_len()` say what the panic
//! said; the module is then to be thrown away. The addresses are valid until the next call.
//!
//! There is no `unsafe` block here: pointers only go out, and it is the page that uses them. The names of the
//! exports are all that the compiler cannot check.

use std::cell::RefCell;

use lafet_play::{COMMAND_MAX, Playground, call as answer_to};

thread_local! {
    static PLAYGROUND: RefCell<Option<Playground>> = const { RefCell::new(None) };
    static COMMAND: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static ANSWER: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static MESSAGE: RefCell<String> = const { RefCell::new(String::new()) };
}

/// Where the page writes a command of this length; null if it is too long.
#[unsafe(no_mangle)]
pub extern "C" fn buffer(len: usize) -> *mut u8 {
    if len > COMMAND_MAX {
        return core::ptr::null_mut();
    }
    COMMAND.with_borrow_mut(|command| {
        command.clear();
        command.resize(len, 0);
        command.as_mut_ptr()
    })
}

/// Executes the command in the buffer; the length of the answer.
#[unsafe(no_mangle)]
pub extern "C" fn call() -> usize {
    PLAYGROUND.with_borrow_mut(|playground| {
        let playground = playground.get_or_insert_with(|| {
            std::panic::set_hook(Box::new(|info| {
                MESSAGE.with(|message| {
                    if let Ok(mut message) = message.try_borrow_mut() {
                        *message = info.to_string();
                    }
                });
            }));
            Playground::default()
        });
        let answer = COMMAND.with_borrow(|command| answer_to(playground, command));
        ANSWER.replace(answer);
    });
    ANSWER.with_borrow(Vec::len)
}

/// The answer to the last command.
#[unsafe(no_mangle)]
pub extern "C" fn answer() -> *const u8 {
    ANSWER.with_borrow(|answer| answer.as_ptr())
}

/// What the panic said that has trapped; empty if there was none.
#[unsafe(no_mangle)]
pub extern "C" fn message() -> *const u8 {
    MESSAGE.with_borrow(|message| message.as_ptr())
}

/// Its length.
#[unsafe(no_mangle)]
pub extern "C" fn message_len() -> usize {
    MESSAGE.with_borrow(String::len)
}
