//! The usual libraries read the exported files of numbers. Some formats refuse calibrations that they cannot contain.

use std::fs;
use std::path::Path;
use std::process::Command;

use loopscope::calibration::{Calibration, Regressor};
use loopscope::export::{TARGETS, read_calibration, target_for, write_calibration};
use loopscope::features::{FeatureSettings, Thresholds};

use crate::support::{calibration, every_block, export, succeed};
use crate::tools::is_there;

/// Runs Python code in `directory`. The variable `truth` holds the JSON of the same calibration.
#[track_caller]
fn python(directory: &Path, code: &str) {
    let head = "import json, numpy as np\ntruth = json.load(open('c.json'))\n";
    succeed(Command::new("python3").current_dir(directory).arg("-c").arg(format!("{head}{code}")));
}

fn exported(calibration: &Calibration, name: &str) -> tempfile::TempDir {
    let directory = tempfile::tempdir().unwrap();
    export(calibration, &directory.path().join("c.json"));
    write_calibration(calibration, &directory.path().join(name)).unwrap();
    directory
}

/// Returns a calibration with names of recordings that must be escaped in files.
fn odd_names() -> Calibration {
    let mut calibration = calibration(every_block(), Regressor::HybridNetwork);
    calibration.trained_on =
        vec!["a \"b\" \\ c: [d]".to_owned(), "力\u{7}\n# no comment".to_owned()];
    calibration
}

/// Python code that checks the arrays, for NumPy and for SciPy.
const SAME_ARRAYS: &str = "
for name in ['conventional', 'compensated']:
    assert np.array_equal(read[name], np.array(truth[name]['matrix'])), name
assert np.array_equal(np.ravel(read['full_scale']), truth['full_scale'])
rated = truth.get('rated') or [False] * len(truth['axes'])
assert np.array_equal(np.ravel(read['rated']), rated)
assert np.array_equal(np.ravel(read['t_th_secs']), [15, 4])
for name in ['gap_secs', 'history_step_secs', 'limits', 'decimation', 'rate_hz', 'offset']:
    assert np.array_equal(np.ravel(read[name]), np.ravel(truth[name])), name
for name in ['shift', 'inverse_scale', 'deviation']:
    assert np.array_equal(np.ravel(read['gauge_' + name]), truth['gauge_scale'][name]), name
for name in ['fixed_lags_secs', 'creep_secs', 'play_radii', 'polynomial']:
    assert np.array_equal(np.ravel(read[name]), np.ravel(truth['features'][name])), name
layers = truth['learned']['network']['layers']
for at, layer in enumerate(layers):
    weights = np.array(layer['weights'], dtype=np.float32)
    assert np.array_equal(np.float32(read[f'weights_{at}']), weights.T), at
";

#[test]
fn numpy_reads_every_array() {
    if !is_there("python3", &["-c", "import numpy"]) {
        return;
    }
    let directory = exported(&odd_names(), "c.npz");
    let texts = "assert list(read['trained_on']) == truth['trained_on']\nassert list(read['gauges']) == truth['gauges']\n";
    let load = "import zipfile\nassert zipfile.ZipFile('c.npz').testzip() is None\nread = np.load('c.npz')\n";
    python(directory.path(), &format!("{load}{SAME_ARRAYS}{texts}"));
}

#[test]
fn scipy_reads_every_array() {
    if !is_there("python3", &["-c", "import scipy.io"]) {
        return;
    }
    let directory = exported(&odd_names(), "c.mat");
    let texts = "assert [t.rstrip() for t in read['gauges']] == truth['gauges']\n\
                 assert all(ord(c) < 128 for t in read['units'] for c in t)\n\
                 names = [t.rstrip(' ') for t in read['trained_on']]\n\
                 shown = lambda c: c if ' ' <= c <= '~' else '\\\\u{%x}' % ord(c)\n\
                 assert names == [''.join(map(shown, t)) for t in truth['trained_on']]\n\
                 assert read['regressor'][0].strip() == truth['regressor']\n";
    let load = "import scipy.io\nread = scipy.io.loadmat('c.mat')\n";
    python(directory.path(), &format!("{load}{SAME_ARRAYS}{texts}"));
}

/// Python code that checks the grammar of ROS 2's parser (rcl_yaml_param_parser). A file has a node's name, `ros__parameters`, then
/// names with values, in maps at most five deep. A value is a scalar, or a list of scalars of one type. No map, list or text is
/// empty. An unquoted scalar is a flag, a whole number, a real number or a text, in this order. A quoted scalar is a text.
const ROS_2: &str = "
import yaml
FLAGS = 'Y y yes Yes YES true True TRUE on On ON N n no No NO false False FALSE off Off OFF'.split()
def kind(node):
    assert isinstance(node, yaml.ScalarNode), 'neither lists nor maps in a list'
    if node.style in ('\"', \"'\"):
        return str
    assert node.value not in ('', '~', 'null', 'Null', 'NULL'), 'no null'
    if node.value in FLAGS:
        return bool
    for number, taken in ((int, lambda text: int(text, 0)), (float, float)):
        try:
            taken(node.value)
            return number
        except ValueError:
            pass
    return str
def parameters(node, depth):
    assert depth <= 5 and node.value
    for name, value in node.value:
        assert name.value.replace('_', '').isalnum(), name.value
        if isinstance(value, yaml.MappingNode):
            parameters(value, depth + 1)
        elif isinstance(value, yaml.SequenceNode):
            kinds = {kind(item) for item in value.value}
            assert len(kinds) == 1, (name.value, kinds)
            assert kinds & {bool, float, str}, name.value
        else:
            kind(value)
root = yaml.compose(open('c.yaml', encoding='utf-8'))
[(node, within)] = root.value
assert node.value == '/**'
[(key, within)] = within.value
assert key.value == 'ros__parameters'
parameters(within, 3)
read = yaml.safe_load(open('c.yaml', encoding='utf-8'))['/**']['ros__parameters']
for name in ['conventional', 'compensated']:
    own = read[name]
    assert np.array_equal(np.reshape(own['matrix'], (own['n_rows'], own['n_columns'])), truth[name]['matrix'])
    assert own['features'] == truth[name]['features']
assert read['trained_on'] == truth['trained_on']
for name in ['gauges', 'axes', 'units', 'full_scale', 'limits', 'offset', 'gap_secs', 'history_step_secs', 'regressor', 'rate_hz']:
    assert read[name] == truth[name], name
assert read['gauge_scale'] == truth['gauge_scale']
features = truth['features']
for name in ['f_th', 't_th_secs']:
    assert read['blocks'].get(name, []) == [own[name] for own in features['look_backs']]
for name in ['fixed_lags_secs', 'creep_secs', 'play_radii', 'polynomial']:
    assert read['blocks'].get(name, []) == features[name], name
";

#[test]
fn ros_2_gets_parameters_that_its_parser_takes_with_the_same_numbers() {
    if !is_there("python3", &["-c", "import yaml, numpy"]) {
        return;
    }
    let directory = exported(&odd_names(), "c.yaml");
    let of_network = "assert 'network' in read['about']['leaves_out']\n";
    python(directory.path(), &format!("{ROS_2}{of_network}"));
    let mut plain = calibration(FeatureSettings::present(), Regressor::Linear);
    plain.trained_on = vec!["1".to_owned(), "no".to_owned(), String::new()];
    python(exported(&plain, "c.yaml").path(), ROS_2);
}

/// Octave reads `.mat` files, but only ASCII characters.
#[test]
fn octave_rebuilds_the_conventional_load() {
    if !is_there("octave", &["--version"]) {
        return;
    }
    let calibration = odd_names();
    let directory = exported(&calibration, "c.mat");
    let code = "c = load('c.mat'); names = fieldnames(c); \
        for k = 1:numel(names), x = c.(names{k}); if ischar(x), assert(all(double(x(:)) < 128)); end, end; \
        printf('%.17g\\n', c.gap_secs, c.history_step_secs, c.conventional * [c.gauge_shift(:); 1]);";
    let mut octave = Command::new("octave");
    let octave = octave.current_dir(directory.path());
    let printed = succeed(octave.args(["--no-gui", "--quiet", "--eval", code]));
    let actual: Vec<f64> = printed.lines().map(|line| line.parse().unwrap()).collect();
    assert_eq!(actual[..2], [calibration.gap_secs, calibration.history_step_secs]);
    let gauges = &calibration.gauge_scale.shift;
    for (row, actual) in calibration.conventional.matrix.iter().zip(&actual[2..]) {
        let load: f64 = gauges.iter().zip(row).map(|(a, b)| a * b).sum::<f64>() + row[6];
        assert!((load - actual).abs() < 1e-12 * (1.0 + load.abs()));
    }
}

#[test]
fn contents_that_a_format_cannot_contain_are_refused_without_writing() {
    let directory = tempfile::tempdir().unwrap();
    let linear = calibration(FeatureSettings::default(), Regressor::Linear);
    let mut small = linear.clone();
    small.axes.pop();
    small.units.pop();
    small.full_scale.pop();
    small.limits.pop();
    small.conventional.matrix.pop();
    small.compensated.as_mut().unwrap().matrix.pop();
    let mut endless = linear.clone();
    endless.features.look_backs[0] = Thresholds { f_th: 3.0, t_th_secs: 1e6 };
    let mut broken = linear.clone();
    broken.conventional.matrix[0].pop();
    for (calibration, name, word) in [
        (&small, "c.cal", "6 gauges and the axes Fx Fy Fz Mx My"),
        (&endless, "c.h", "smaller t_th"),
        (&broken, "c.yaml", "row Fx"),
        (&linear, "gone/c.h", "no folder"),
    ] {
        let message =
            write_calibration(calibration, &directory.path().join(name)).unwrap_err().to_string();
        assert!(message.contains(name) && message.contains(word), "{message}");
    }
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 0);
}

/// Endings may be in upper or lower case. Every text file lists its omitted parts.
#[test]
fn every_format_is_found_by_its_endings_and_names_the_missing_parts() {
    let directory = tempfile::tempdir().unwrap();
    let network = calibration(every_block(), Regressor::Network);
    for target in TARGETS {
        for ending in target.endings {
            let path = directory.path().join(format!("c.{}", ending.to_ascii_uppercase()));
            assert_eq!(target_for(&path).unwrap().name, target.name);
            write_calibration(&network, &path).unwrap();
            let text = String::from_utf8_lossy(&fs::read(&path).unwrap()).into_owned();
            let says = ["leaves out", "leaves_out", "l\0\0\0e\0\0\0a\0\0\0v\0\0\0e\0\0\0s"];
            let is_table = ["json", "csv", "mat", "dat", "zip"].contains(ending);
            assert!(is_table || says.iter().any(|words| text.contains(words)), "{ending}");
            assert_eq!(read_calibration(&path).is_ok(), target.reader.is_some(), "{ending}");
        }
    }
}
