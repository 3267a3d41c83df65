//! Byte queue -> [`Line`]: blanks and comments removed, upper case, one for each end of line.

use heapless::String;

/// Longest line after removal of blanks and comments.
pub const LONGEST: usize = 256;

/// A line without blanks and comments, in upper case.
pub type Line = String<LONGEST>;

/// A line longer than [`LONGEST`]; none of it is run.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TooLong;

/// Collects bytes until a line is over.
#[derive(Debug, Default)]
pub struct LineReader {
    line: Line,
    too_long: bool,
    comment: Comment,
    after_return: bool,
}

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
enum Comment {
    #[default]
    None,
    Round,
    ToEnd,
}

impl LineReader {
    /// One byte; a line when it ends here. CR, LF and the pair CR LF end a line, the pair once.
    pub fn push(&mut self, byte: u8) -> Option<Result<Line, TooLong>> {
        let pair = self.after_return && byte == b'\n';
        self.after_return = byte == b'\r';
        if byte == b'\r' || byte == b'\n' {
            return if pair { None } else { Some(self.finish()) };
        }
        match (self.comment, byte) {
            (Comment::Round, b')') => self.comment = Comment::None,
            (Comment::Round | Comment::ToEnd, _) | (_, b' ') => {}
            (Comment::None, b'(') => self.comment = Comment::Round,
            (Comment::None, b';') => self.comment = Comment::ToEnd,
            (Comment::None, 0x08 | 0x7f) => {
                self.line.pop();
            }
            (Comment::None, _) => {
                let letter = char::from(byte.to_ascii_uppercase());
                self.too_long |= self.line.push(letter).is_err();
            }
        }
        None
    }

    /// Forgets what has been collected.
    pub fn clear(&mut self) {
        *self = Self {
            after_return: self.after_return,
            ..Self::default()
        };
    }

    /// The line that is being collected must not be run: bytes of it were lost.
    pub fn spoil(&mut self) {
        self.too_long = true;
    }

    fn finish(&mut self) -> Result<Line, TooLong> {
        let too_long = self.too_long;
        let line = core::mem::take(&mut self.line);
        self.comment = Comment::None;
        self.too_long = false;
        if too_long { Err(TooLong) } else { Ok(line) }
    }
}
