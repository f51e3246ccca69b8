//! Padding against lines that run together: where a newline, or more, is lost on the wire, what is left must not look like one
//! good line to an XOR of eight bits. Bytes that say nothing are put in where it would.

use memchr::memchr;

use super::wire::{checksum, integer_digits, push_integer};

/// What a line adds to the checksum of the line that it runs into: its own sum, `*` and the sum's digits.
///
/// Never 0, so that two lines in one are refused. Three are not where the first two add the same: XOR cancels. [`Padder`]
/// keeps that from happening.
fn added(sum: u8) -> u8 {
    let digits = [sum / 100, sum / 10 % 10, sum % 10].map(|d| b'0' + d);
    let used = if sum >= 100 {
        0
    } else if sum >= 10 {
        1
    } else {
        2
    };
    digits[used..].iter().fold(sum ^ b'*', |all, digit| all ^ digit)
}

/// Bytes that say nothing, put in so that lines that run together never look like a good one.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Padding {
    /// A leading zero of the number.
    zero: bool,
    /// A blank behind it.
    blank: bool,
    /// A zero behind the block's first fraction.
    tail: bool,
}

impl Padding {
    /// The most bytes that it adds.
    pub(crate) const MOST: usize = 3;

    /// None, but for the blank behind the number where that is wanted.
    pub(crate) fn least(blank: bool) -> Self {
        Self { blank, ..Self::default() }
    }

    /// The same with a blank behind the number.
    pub(crate) fn spaced(self) -> Self {
        Self { blank: true, ..self }
    }

    /// Whether a blank stands behind the number.
    pub(crate) fn is_spaced(self) -> bool {
        self.blank
    }
}

/// The end of the block's first fraction, where one more zero says nothing; `None` without a fraction, and in texts.
fn fraction_end(block: &[u8]) -> Option<usize> {
    let point = memchr(b'.', block).filter(|_| matches!(block.get(..2), Some(b"G0" | b"G1" | b"G2" | b"G3")))?;
    let digits = block[point + 1..].iter().take_while(|b| b.is_ascii_digit()).count();
    (digits > 0).then_some(point + 1 + digits)
}

/// What the last lines add: where several of them run together the sums must not cancel, and neither may the beginning of one
/// that is cut anywhere and runs into the next.
///
/// Two whole lines never cancel. Against the other cases the best of four paddings is taken; an XOR of eight bits cannot be
/// made proof against everything (measured in the tests: a fiftieth of the cut lines and an eighth of the runs are left that
/// plain lines would let pass).
#[derive(Clone, Debug, Default)]
pub(crate) struct Padder {
    /// Sums of what all lines add, up to each of the last ones, the newest first.
    sums: [u8; Self::RUN],
    sum: u8,
}

impl Padder {
    const RUN: usize = 5;

    /// The padding with which line `number` ends no run that cancels; the least where that is so already. Always a blank behind the
    /// number where that is wanted.
    pub(crate) fn pad(&mut self, number: i64, block: &[u8], blank: bool) -> Padding {
        let mut digits = [0_u8; 21];
        let head = checksum(integer_digits(&mut digits, number)) ^ b'N';
        let block_sum = checksum(block);
        let tail = fraction_end(block);
        let head_of = |f: &Padding| head ^ if f.zero { b'0' } else { 0 } ^ if f.blank { b' ' } else { 0 };
        let whole = |f: &Padding| head_of(f) ^ block_sum ^ if f.tail { b'0' } else { 0 };
        let sum_with = |f: &Padding| self.sum ^ added(whole(f));
        let nearest = |f: &Padding| self.sums.iter().position(|s| *s == sum_with(f)).unwrap_or(Self::RUN);
        let beginnings = [Beginnings::of(block, None), Beginnings::of(block, tail)];
        let safe = |f: &Padding| !beginnings[usize::from(f.tail)].cancel(head_of(f), whole(f));
        let rank = |f: &Padding| (safe(f), nearest(f));
        let mut padding = Padding::least(blank);
        for bits in 1_u8..if tail.is_some() { 8 } else { 4 } {
            if rank(&padding) == (true, Self::RUN) {
                break;
            }
            let other = Padding { zero: bits & 1 > 0, blank: blank || bits & 2 > 0, tail: bits & 4 > 0 };
            if rank(&other) > rank(&padding) {
                padding = other;
            }
        }
        self.sum = sum_with(&padding);
        self.sums.copy_within(0..Self::RUN - 1, 1);
        self.sums[0] = self.sum;
        padding
    }
}

/// The sums of all beginnings of a block. A line that is cut where its sum is 0 runs into the next one unseen.
struct Beginnings([u64; 4]);

impl Beginnings {
    /// With one more zero at `zero_at`.
    fn of(block: &[u8], zero_at: Option<usize>) -> Self {
        let mut seen = Self([0; 4]);
        let mut sum = 0_u8;
        for (index, byte) in block.iter().enumerate() {
            if zero_at == Some(index) {
                sum ^= b'0';
                seen.add(sum);
            }
            sum ^= byte;
            seen.add(sum);
        }
        if zero_at == Some(block.len()) {
            seen.add(sum ^ b'0');
        }
        seen
    }

    fn add(&mut self, sum: u8) {
        self.0[usize::from(sum >> 6)] |= 1 << (sum & 63);
    }

    fn contain(&self, sum: u8) -> bool {
        self.0[usize::from(sum >> 6)] >> (sum & 63) & 1 == 1
    }

    /// Whether a beginning of the line sums to 0, where what stands before the block sums to `head`, all of it to `whole`.
    fn cancel(&self, head: u8, whole: u8) -> bool {
        let digits = [whole / 100, whole / 10 % 10].map(|d| b'0' + d);
        let first = if whole >= 100 { digits[0] } else { digits[1] };
        let behind = [whole ^ b'*', whole ^ b'*' ^ first, whole ^ b'*' ^ digits[0] ^ digits[1]];
        self.contain(head) || behind[..if whole >= 100 { 3 } else { 2 }].contains(&0)
    }
}

/// As [`push_numbered`](super::wire::push_numbered), with a padding.
pub(crate) fn push_padded(out: &mut Vec<u8>, number: i64, padding: Padding, block: &[u8]) {
    let start = out.len();
    out.push(b'N');
    if padding.zero {
        out.push(b'0');
    }
    push_integer(out, number);
    if padding.blank {
        out.push(b' ');
    }
    match fraction_end(block).filter(|_| padding.tail) {
        Some(end) => {
            out.extend_from_slice(&block[..end]);
            out.push(b'0');
            out.extend_from_slice(&block[end..]);
        }
        None => out.extend_from_slice(block),
    }
    let sum = checksum(&out[start..]);
    out.push(b'*');
    push_integer(out, i64::from(sum));
    out.push(b'\n');
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::link::wire::{numbered_len, push_numbered};

    /// Two lines of which the newline between was lost never look like one good line.
    #[test]
    fn joined_lines_never_pass_the_checksum() {
        for sum in 0..=255_u8 {
            let mut between = format!("*{sum}").into_bytes();
            between.insert(0, sum);
            assert_ne!(checksum(&between), 0, "a body that sums to {sum}");
            assert_eq!(checksum(&between), added(sum));
        }
    }

    /// Nor do three or more, which plain lines sometimes do; as Marlin checks it: the sum in front of the last `*`.
    #[test]
    fn lines_run_together_or_cut_hardly_ever_pass_the_checksum() {
        let passes = |lines: &[Vec<u8>]| {
            let joined: Vec<u8> = lines.iter().flat_map(|l| l[..l.len() - 1].to_vec()).collect();
            let star = joined.iter().rposition(|b| *b == b'*').unwrap();
            std::str::from_utf8(&joined[star + 1..]).unwrap().parse::<u8>().unwrap() == checksum(&joined[..star])
        };
        let (mut plain, mut padded, mut padder) = (Vec::new(), Vec::new(), Padder::default());
        for number in 1..20_000_i64 {
            let block = format!("G1X{}Y-98.{} E.0{}", number % 97, number % 1000, 3000 + number % 777);
            let (mut one, mut two) = (Vec::new(), Vec::new());
            push_numbered(&mut one, number, block.as_bytes());
            let padding = padder.pad(number, block.as_bytes(), false);
            push_padded(&mut two, number, padding, block.as_bytes());
            assert!(two.len() <= numbered_len(number, block.as_bytes()) + Padding::MOST);
            plain.push(one);
            padded.push(two);
        }
        let count = |lines: &[Vec<u8>], run: usize| lines.windows(run).filter(|w| passes(w)).count();
        assert!(count(&plain, 3) > 100, "the danger is real: {}", count(&plain, 3));
        assert_eq!(count(&padded, 2), 0);
        let runs = |lines: &[Vec<u8>]| (3..=6).map(|run| count(lines, run)).sum::<usize>();
        assert!(runs(&padded) * 8 < runs(&plain), "{} {}", runs(&padded), runs(&plain));
        // A line cut anywhere, its end lost with the newline, runs into the next.
        let cut = |lines: &[Vec<u8>]| {
            let pairs = lines.windows(2);
            pairs
                .map(|w| (1..w[0].len()).filter(|&n| passes(&[[&w[0][..n], b"\n"].concat(), w[1].clone()])).count())
                .sum::<usize>()
        };
        assert!(cut(&plain) > 1000 && cut(&padded) * 50 < cut(&plain), "{} {}", cut(&plain), cut(&padded));
        let bytes = |lines: &[Vec<u8>]| lines.iter().map(Vec::len).sum::<usize>() as f64;
        assert!(bytes(&padded) < bytes(&plain) * 1.03, "{}", bytes(&padded) / bytes(&plain));
    }
}
