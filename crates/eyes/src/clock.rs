//! When a picture was taken, by the camera's clock: the sender reports of RTCP relate RTP's time to a date.

/// Seconds from 1900, which NTP counts from, to 1970.
const TO_1970: u64 = 2_208_988_800;
/// Before this date, 2020, a camera does not know what time it is.
const KNOWN_US: u64 = 1_577_836_800_000_000;

/// The last report.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Report {
    /// Its date, as NTP has it: 32 bits of seconds, 32 of their parts.
    pub ntp: u64,
    /// The same moment in RTP's time.
    pub rtp: u32,
}

impl Report {
    /// The date of a moment of RTP's time, µs since 1970, if the camera knows the date.
    pub fn date_us(self, rtp: u32, rate: u32) -> Option<u64> {
        let seconds = (self.ntp >> 32).checked_sub(TO_1970)?;
        let parts = ((self.ntp & 0xFFFF_FFFF) * 1_000_000) >> 32;
        let date = i64::try_from(seconds * 1_000_000 + parts).ok()?;
        // The pictures around a report are before and after it.
        let since = i64::from(rtp.wrapping_sub(self.rtp).cast_signed());
        let since_us = since.checked_mul(1_000_000)?.checked_div(i64::from(rate))?;
        u64::try_from(date.checked_add(since_us)?).ok().filter(|it| *it >= KNOWN_US)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const RATE: u32 = 90_000;

    fn ntp(seconds: u64) -> u64 {
        (seconds + TO_1970) << 32
    }

    #[test]
    fn pictures_before_and_after_a_report_have_their_dates() {
        let report = Report { ntp: ntp(1_763_712_000) | 1 << 31, rtp: 10 };
        let date = |rtp| report.date_us(rtp, RATE);
        assert_eq!(date(10), Some(1_763_712_000_500_000));
        assert_eq!(date(10 + RATE), Some(1_763_712_001_500_000));
        assert_eq!(date(10_u32.wrapping_sub(RATE)), Some(1_763_711_999_500_000), "over the wrap");
    }

    #[test]
    fn a_camera_without_a_date_has_none() {
        let date = |ntp, rate| Report { ntp, rtp: 0 }.date_us(0, rate);
        assert_eq!(date(0, RATE), None, "1900");
        assert_eq!(date(ntp(3600), RATE), None, "an hour after 1970");
        assert_eq!(date(ntp(1_763_712_000), 0), None);
        assert_eq!(date(u64::MAX, RATE).is_some(), date(u64::MAX - 1, RATE).is_some());
    }
}
