//! The curve of a line that hangs from its two ends.

use bevy_math::DVec3;

/// Chords longer than the line by no more than this part of its length are taut: the rounding of places
/// in single precision.
const ROUNDING: f64 = 1e-6;
/// Half the span in units of the curve's parameter below which the line is straight: its sag is less than
/// 3e-7 of its span.
const TAUT: f64 = 1e-6;
/// Horizontal span in units of the length below which the line is folded.
const FOLDED: f64 = 1e-9;

/// Why no line hangs between two places.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum CatenaryError {
    /// An end or the direction of gravity is not finite.
    #[error("an end of the line, or the direction of gravity, is not finite")]
    NonFinite,
    /// The length is not positive and finite.
    #[error("a line cannot be {0} m long: its length must be positive and finite")]
    Length(f64),
    /// There is no gravity.
    #[error("without gravity nothing hangs: give the direction in which it pulls")]
    NoGravity,
    /// Both ends are at the same place.
    #[error("both ends of the line are at the same place")]
    Coincident,
    /// The ends are further apart than the line is long.
    #[error("the ends are {chord} m apart, but the line is {length} m long")]
    TooFar {
        /// Distance of the ends \[m\].
        chord: f64,
        /// Length of the line \[m\].
        length: f64,
    },
}

/// An inextensible line that hangs from its two ends, under gravity in any direction: a catenary, told by
/// the way along it.
///
/// With `D` the horizontal span, `h` the difference of the heights and `L` the length, the parameter `c`
/// is the root of `sqrt(L^2 - h^2) = 2 c sinh(D / 2 c)`. Where the chord is vertical the line is folded,
/// down and up again; where it is as long as the line, the line is straight.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Catenary {
    ends: [DVec3; 2],
    length: f64,
    up: DVec3,
    form: Form,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Form {
    /// Straight from end to end; longer than the line, where that is stretched.
    Straight,
    /// Down to this way along the line, and up again.
    Folded { lowest: f64 },
    /// Arc of the curve `y = c cosh(x / c)`.
    Curve {
        /// The parameter \[m\]: horizontal tension over weight per length.
        c: f64,
        /// Horizontal unit vector from the first end to the second.
        across: DVec3,
        /// Signed way from the lowest point of the whole curve to the first end \[m\].
        start: f64,
    },
}

impl Catenary {
    /// The line of `length` \[m\] between two places \[m\], where gravity pulls along `down` (of any
    /// length).
    ///
    /// # Errors
    /// [`CatenaryError`], see there.
    pub fn new(from: DVec3, to: DVec3, length: f64, down: DVec3) -> Result<Self, CatenaryError> {
        if !(from.is_finite() && to.is_finite() && down.is_finite()) {
            return Err(CatenaryError::NonFinite);
        }
        if !(length > 0.0 && length.is_finite()) {
            return Err(CatenaryError::Length(length));
        }
        let up = -down.try_normalize().ok_or(CatenaryError::NoGravity)?;
        let chord = from.distance(to);
        if chord <= ROUNDING * length {
            return Err(CatenaryError::Coincident);
        }
        if chord > length * (1.0 + ROUNDING) {
            return Err(CatenaryError::TooFar { chord, length });
        }
        Ok(Self::hung_or_stretched(from, to, length, up))
    }

    /// The same for places that are in order, with the unit vector upwards: ends at one place fold the
    /// line, and one that is too short is stretched.
    pub(super) fn hung_or_stretched(from: DVec3, to: DVec3, length: f64, up: DVec3) -> Self {
        let form = form(to - from, length, up);
        Self { ends: [from, to], length, up, form }
    }

    /// Length of the line \[m\].
    pub fn length(&self) -> f64 {
        self.length
    }

    /// The parameter `c` of `y = c cosh(x / c)` \[m\]: the horizontal tension over the weight per length.
    /// Infinite where the line is straight, 0 where it is folded.
    pub fn parameter(&self) -> f64 {
        match self.form {
            Form::Straight => f64::INFINITY,
            Form::Folded { .. } => 0.0,
            Form::Curve { c, .. } => c,
        }
    }

    /// The place at a way from the first end along the line \[m\], which is taken into its length.
    pub fn at(&self, way: f64) -> DVec3 {
        let [from, to] = self.ends;
        let way = way.clamp(0.0, self.length);
        match self.form {
            Form::Straight if self.length == 0.0 => from,
            Form::Straight => from.lerp(to, way / self.length),
            Form::Folded { lowest } if way <= lowest => from - self.up * way,
            Form::Folded { .. } => to - self.up * (self.length - way),
            Form::Curve { c, across, start } => {
                let end = start + way;
                let x = c * (libm::asinh(end / c) - libm::asinh(start / c));
                // The difference of sqrt(c^2 + s^2) at both, without cancellation.
                let y = way * (end + start)
                    / ((c * c + end * end).sqrt() + (c * c + start * start).sqrt());
                from + across * x + self.up * y
            }
        }
    }

    /// Places at equal ways along the line, both ends with them.
    pub fn points(&self, count: usize) -> impl ExactSizeIterator<Item = DVec3> + '_ {
        let last = count.saturating_sub(1).max(1) as f64;
        (0..count).map(move |i| self.at(self.length * (i as f64 / last)))
    }
}

/// The form of a line whose second end is at `chord` from the first.
fn form(chord: DVec3, length: f64, up: DVec3) -> Form {
    let distance = chord.length();
    if distance >= length {
        return Form::Straight;
    }
    let height = chord.dot(up);
    let level = chord - up * height;
    let span = level.length();
    if span <= FOLDED * length {
        return Form::Folded { lowest: 0.5 * (length - height) };
    }
    // sqrt(L^2 - h^2) / D, less one: written so that nothing cancels where the line is nearly taut.
    let ratio = ((length - height) * (length + height)).sqrt() / span;
    let excess = (length - distance) * (length + distance) / (span * span) / (ratio + 1.0);
    let half = half_span(excess);
    if half <= TAUT {
        return Form::Straight;
    }
    let c = 0.5 * span / half;
    // Half way across, the curve is as steep as the chord of a line of this length.
    let tilt = 0.5 * libm::log((length + height) / (length - height));
    Form::Curve { c, across: level / span, start: c * libm::sinh(tilt - half) }
}

/// Solves `sinh(x) / x = 1 + excess` for x from 0.
///
/// Newton's method on the logarithm of both sides: that is convex, so that it comes down to the root from
/// an upper bound. Kept between bounds all the same, as rounding may do anything.
fn half_span(excess: f64) -> f64 {
    let goal = libm::log1p(excess);
    // The first term of the series alone.
    let (mut low, mut high) = (0.0, (6.0 * excess).sqrt());
    let mut x = high;
    for _ in 0..64 {
        let (value, slope) = log_sinhc(x);
        if value > goal {
            high = x;
        } else {
            low = x;
        }
        let newton = x - (value - goal) / slope;
        let next = if newton > low && newton < high { newton } else { 0.5 * (low + high) };
        if (next - x).abs() <= 1e-15 * x {
            break;
        }
        x = next;
    }
    x
}

/// `ln(sinh(x) / x)` and its slope.
fn log_sinhc(x: f64) -> (f64, f64) {
    if x < 0.25 {
        let q = x * x;
        let series = q / 6.0 * (1.0 + q / 20.0 * (1.0 + q / 42.0 * (1.0 + q / 72.0)));
        let slope = x / 3.0 * (1.0 - q / 15.0 * (1.0 - q * 2.0 / 21.0 * (1.0 - q / 10.0)));
        return (libm::log1p(series), slope);
    }
    let twice = libm::expm1(-2.0 * x);
    // sinh(x) = exp(x) (1 - exp(-2 x)) / 2: large x do not overflow.
    (x + libm::log(-twice / (2.0 * x)), -(2.0 + twice) / twice - 1.0 / x)
}
