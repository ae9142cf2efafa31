//! Samples of enums whose texts are listed, at least one of each variant.

use std::fmt::Debug;

/// The samples, each behind the pattern that it fits. A variant without an arm does not compile.
#[macro_export]
macro_rules! samples {
    ($kind:ty { $($pattern:pat => $($sample:expr),+;)+ }) => {{
        #[allow(dead_code)]
        fn covers(value: &$kind) {
            match value {
                $($pattern => (),)+
            }
        }
        let mut samples: Vec<$kind> = Vec::new();
        $(for sample in [$($sample),+] {
            assert!(matches!(&sample, $pattern), "{sample:?} is listed for another variant");
            samples.push(sample);
        })+
        samples
    }};
}
pub use samples;

/// The heading, and one line for each sample: variant and text.
pub fn listed<T: Debug>(heading: &str, samples: &[T], text: impl Fn(&T) -> String) -> String {
    let lines = samples.iter().map(|sample| {
        let debug = format!("{sample:?}");
        let variant = debug.split([' ', '(', '{']).next().unwrap_or_default();
        format!("  {variant}: {}\n", text(sample))
    });
    format!("{heading}\n{}", lines.collect::<String>())
}
