//! Times two things in turns, so that what else the machine does hits both alike, and prints them.

/// Median times \[us\].
pub struct Turns {
    pub without: f64,
    pub with: f64,
    /// Of what the second took longer than the first beside it.
    pub more: f64,
}

/// What a cost is held to. A machine that is slow or busy is no error: it is only told.
pub enum Bound {
    None,
    /// So many times the time without.
    Times(f64),
    /// So many percent more than without.
    Percent(f64),
    /// So many microseconds more for each of a number of things.
    Each(f64, u32),
}

/// What has been found to be wrong, apart from times.
#[derive(Default)]
pub struct Wrong(pub Vec<String>);

impl Wrong {
    /// Notes what is wrong with `name`, unless it `holds`.
    pub fn unless(&mut self, holds: bool, name: &str, what: &str) {
        if !holds {
            self.0.push(format!("{name}: {what}"));
        }
    }
}

/// Times two things in turns, each of which tells its own time \[us\].
pub fn in_turns(
    rounds: usize,
    mut without: impl FnMut() -> f64,
    mut with: impl FnMut() -> f64,
) -> Turns {
    let mut times = [const { Vec::new() }; 3];
    for round in 0..rounds {
        let (a, b) = if round % 2 == 0 {
            let a = without();
            (a, with())
        } else {
            let b = with();
            (without(), b)
        };
        for (times, time) in times.iter_mut().zip([a, b, b - a]) {
            times.push(time);
        }
    }
    let [without, with, more] = times.map(median);
    Turns { without, with, more }
}

pub fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times.get(times.len() / 2).copied().unwrap_or(f64::NAN)
}

pub fn heading(title: &str, without: &str, with: &str) {
    println!("\n{title:50} {without:>10} {with:>10}       more");
}

pub fn line(name: &str, turns: &Turns, bound: Bound) {
    let Turns { without, with, more } = *turns;
    let percent = 100.0 * more / without;
    let print = |more: String| print!("  {name:48} {without:10.1} {with:10.1}  {more}");
    let (value, most) = match bound {
        Bound::Times(most) => (with / without, most),
        Bound::Percent(most) => (percent, most),
        Bound::Each(most, count) => (more / f64::from(count), most),
        Bound::None => (0.0, 0.0),
    };
    match bound {
        Bound::Times(_) => print(format!("{value:6.2} times, bound {most}")),
        Bound::Each(..) => print(format!("{value:6.3} us each, bound {most}")),
        Bound::Percent(_) => print(format!("{more:+6.1} us {percent:+6.2} %, bound {most}")),
        Bound::None => print(format!("{more:+6.1} us {percent:+6.2} %")),
    }
    println!("{}", if value > most { ": MISSED" } else { "" });
}
