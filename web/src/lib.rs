//! The playground's engine: requests as JSON in, answers as JSON out, for a worker of a page.
//!
//! The page writes a request to the memory that [`request`] names and calls [`answer`]: its text, and behind it the bytes of files
//! that it speaks of. No bindings are generated, as nothing but bytes goes either way. What
//! each verb takes and gives stands in `verbs.rs`.

mod training;
mod verbs;

use std::cell::RefCell;

thread_local! {
    static REQUEST: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
    static ANSWER: RefCell<Vec<u8>> = const { RefCell::new(Vec::new()) };
}

/// Most bytes of a request: a file of a page is held once here and read to some times its size.
pub const MOST_BYTES: usize = 64 << 20;

/// Room for a request of so many bytes; its address, or 0 if that is more than [`MOST_BYTES`].
#[unsafe(no_mangle)]
pub extern "C" fn request(bytes: usize) -> *mut u8 {
    if bytes > MOST_BYTES {
        return std::ptr::null_mut();
    }
    REQUEST.with_borrow_mut(|request| {
        *request = vec![0; bytes];
        request.as_mut_ptr()
    })
}

/// Answers the request: its first `text` bytes are JSON, the others files. The number of bytes of the answer, which begins at
/// [`answer_address`].
#[unsafe(no_mangle)]
pub extern "C" fn answer(text: usize) -> usize {
    let request = REQUEST.take();
    let (text, files) = request.split_at(text.min(request.len()));
    let answered = verbs::answer(text, files).into_bytes();
    let bytes = answered.len();
    ANSWER.set(answered);
    bytes
}

/// Where the last answer begins.
#[unsafe(no_mangle)]
pub extern "C" fn answer_address() -> *const u8 {
    ANSWER.with_borrow(|answer| answer.as_ptr())
}

/// Milliseconds of the page's clock.
#[cfg(target_arch = "wasm32")]
pub(crate) fn now() -> f64 {
    #[link(wasm_import_module = "page")]
    unsafe extern "C" {
        safe fn now() -> f64;
    }
    now()
}

/// Milliseconds of a clock.
#[cfg(not(target_arch = "wasm32"))]
pub(crate) fn now() -> f64 {
    use std::sync::LazyLock;
    use std::time::Instant;
    static BEGIN: LazyLock<Instant> = LazyLock::new(Instant::now);
    1e3 * BEGIN.elapsed().as_secs_f64()
}
