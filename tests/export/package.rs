//! Exported libraries. The tests build and run their self-tests as a user does.

use std::fs;
use std::io::{Cursor, Read as _};
use std::path::Path;
use std::process::Command;

use loopscope::calibration::Regressor;
use loopscope::export::write_calibration;
use loopscope::features::{FeatureSettings, Play};

use crate::c::STRICT;
use crate::support::{calibration, calibrations, drifting, every_block, learned, succeed};
use crate::tools::is_there;

/// Runs a self-test and checks that it prints PASS and compares most samples.
#[track_caller]
fn passes(command: &mut Command, what: &str) {
    let printed = succeed(command);
    assert!(printed.starts_with("PASS: "), "{what}: {printed}");
    // Only samples at the edge of a threshold are not compared, and these are few.
    let numbers: Vec<f64> = printed.split(' ').filter_map(|word| word.parse().ok()).collect();
    assert!(numbers[0] > 0.7 * numbers[1], "{what}: {printed}");
}

/// Builds `main.c` with this compiler and these options. Returns the command that runs the self-test.
#[track_caller]
fn built(compiler: &str, options: &[&str], folder: &Path) -> Command {
    let program = folder.join("selftest");
    let mut compile = Command::new(compiler);
    compile.args(options).arg("-o").arg(&program);
    compile.arg(format!("-I{}", folder.join("src").display()));
    let cpp: &[&str] = if compiler == "g++" { &["-x", "c++"] } else { &[] };
    succeed(compile.args(cpp).arg(folder.join("main.c")).arg("-lm"));
    let mut run = Command::new(program);
    run.arg(folder.join("expected.csv"));
    run
}

#[test]
fn every_library_passes_its_own_test_in_c_and_in_cpp() {
    if !is_there("cc", &["--version"]) || !is_there("g++", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let drifting = [Regressor::Linear, Regressor::HybridKernel].map(|regressor| {
        let name = format!("drifting_{}", regressor.key().replace('-', "_"));
        (name, drifting(regressor))
    });
    for (name, calibration) in calibrations().into_iter().chain(drifting) {
        let folder = directory.path().join(&name);
        write_calibration(&calibration, &directory.path().join(format!("{name}/"))).unwrap();
        for real in ["-DLOOPSCOPE_REAL=double", "-DLOOPSCOPE_REAL=float"] {
            let strict = [&STRICT, &["-O1", real][..]].concat();
            passes(&mut built("cc", &strict, &folder), &format!("{name} {real}"));
            let strict: Vec<&str> =
                strict.iter().map(|option| option.replace("c99", "c++17").leak() as &str).collect();
            passes(&mut built("g++", &strict, &folder), &format!("{name} {real} C++"));
        }
    }
}

#[test]
fn a_wrong_number_fails_the_self_test() {
    if !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    write_calibration(
        &calibration(every_block(), Regressor::Linear),
        &directory.path().join("left arm/"),
    )
    .unwrap();
    let folder = directory.path().join("left arm");
    let mut run = built("cc", &["-std=c99"], &folder);
    let expected = fs::read_to_string(folder.join("expected.csv")).unwrap();
    let mut lines: Vec<String> = expected.lines().map(str::to_owned).collect();
    let line = lines[30].replacen(",1,0", ",0,0", 1);
    assert_ne!(lines[30], line, "the status shows that the history fills");
    lines[30] = line;
    fs::write(folder.join("expected.csv"), lines.join("\n")).unwrap();
    let output = run.output().unwrap();
    let printed = String::from_utf8(output.stdout).unwrap();
    assert_eq!(output.status.code(), Some(1));
    assert!(printed.starts_with("line 31: ") && printed.contains("FAIL: "), "{printed}");
    fs::write(folder.join("expected.csv"), lines[..20].join("\n")).unwrap();
    assert_eq!(run.output().unwrap().status.code(), Some(2));
}

#[test]
fn cmake_builds_and_tests_a_library() {
    if !is_there("cmake", &["--version"]) || !is_there("cc", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    write_calibration(
        &calibration(every_block(), Regressor::Linear),
        &directory.path().join("test/"),
    )
    .unwrap();
    let build = directory.path().join("build");
    for options in [vec![], vec!["-DLOOPSCOPE_REAL=float"]] {
        let mut cmake = Command::new("cmake");
        cmake.arg("-S").arg(directory.path().join("test")).arg("-B").arg(&build);
        succeed(cmake.args(options));
        succeed(Command::new("cmake").arg("--build").arg(&build));
        let printed = succeed(Command::new("ctest").arg("-V").current_dir(&build));
        assert!(printed.contains("PASS: ") && printed.contains("100% tests passed"), "{printed}");
        if is_there("python3", &["--version"]) {
            assert!(
                printed.lines().any(|line| line.contains(" shared ") && line.contains("Passed")),
                "{printed}"
            );
        }
        let installed = directory.path().join("installed");
        let mut install = Command::new("cmake");
        succeed(install.arg("--install").arg(&build).arg("--prefix").arg(&installed));
        assert!(installed.join("lib").read_dir().unwrap().count() > 0);
    }
}

/// Compiles the example as C++, with Arduino's declarations.
#[test]
fn the_example_for_arduino_compiles() {
    if !is_there("g++", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let mut calibration = calibration(every_block(), Regressor::Linear);
    calibration.gauges[1] = "*/ #error \\".to_owned();
    write_calibration(&calibration, &directory.path().join("arm/")).unwrap();
    let folder = directory.path().join("arm");
    let arduino = "
        #include <stddef.h>
        const int A0 = 14;
        int analogRead(int);
        unsigned long micros();
        struct Port { void begin(long); void print(float, int); void print(char); };
        extern Port Serial;
    ";
    fs::write(folder.join("Arduino.h"), arduino).unwrap();
    let mut compile = Command::new("g++");
    compile.args(["-std=c++11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-include"]);
    compile.arg(folder.join("Arduino.h")).arg(format!("-I{}", folder.join("src").display()));
    succeed(compile.args(["-x", "c++"]).arg(folder.join("examples/read_load/read_load.ino")));
    write_calibration(&drifting(Regressor::Linear), &directory.path().join("warm/")).unwrap();
    let warm = directory.path().join("warm");
    let mut compile = Command::new("g++");
    compile.args(["-std=c++11", "-Wall", "-Wextra", "-Werror", "-fsyntax-only", "-include"]);
    compile.arg(folder.join("Arduino.h")).arg(format!("-I{}", warm.join("src").display()));
    succeed(compile.args(["-x", "c++"]).arg(warm.join("examples/read_load/read_load.ino")));
    let library = fs::read_to_string(folder.join("library.json")).unwrap();
    let library: serde_json::Value = serde_json::from_str(&library).unwrap();
    assert_eq!(library["headers"], "arm.h");
}

/// Declarations of ROS 2 that the node uses, and a `spin` that feeds it messages: good, without a number, of the wrong length, from the
/// past, and good again.
const ROS: &str = r#"
    #include <cmath>
    #include <cstdint>
    #include <cstdio>
    #include <functional>
    #include <memory>
    #include <string>
    #include <vector>
    static double clock_secs = 0;
    static std::function<void(const std::vector<double> &)> deliver;
    namespace rclcpp {
    struct Time { double secs; double seconds() const { return secs; } };
    struct Clock {};
    struct Logger {};
    struct SensorDataQoS {};
    template <class T> struct Publisher {
        typedef std::shared_ptr<Publisher> SharedPtr;
        void publish(const T &message) { message.print(); }
    };
    template <class T> struct Subscription { typedef std::shared_ptr<Subscription> SharedPtr; };
    struct Node {
        explicit Node(const char *) {}
        template <class T> T declare_parameter(const char *, T value) { return value; }
        template <class T> typename Publisher<T>::SharedPtr create_publisher(const char *, SensorDataQoS)
        {
            return std::make_shared<Publisher<T>>();
        }
        template <class T, class F>
        typename Subscription<T>::SharedPtr create_subscription(const char *, SensorDataQoS, F callback)
        {
            deliver = [callback](const std::vector<double> &data) { T message; message.data = data; callback(message); };
            return std::make_shared<Subscription<T>>();
        }
        Time now() { return {clock_secs}; }
        Logger get_logger() { return {}; }
        std::shared_ptr<Clock> get_clock() { return std::make_shared<Clock>(); }
    };
    inline void init(int, char **) {}
    inline void shutdown() {}
    inline void spin(std::shared_ptr<Node>)
    {
        const size_t n = INPUTS;
        std::vector<double> good(n, 0.25), bad(n, 0.25);
        bad[0] = NAN;
        const std::vector<double> messages[] = {good, bad, std::vector<double>(n + 1, 0.25), good, good};
        const double times[] = {10, 10.05, 10.1, 5, 10.15};
        for (int at = 0; at < 5; at++) {
            clock_secs = times[at];
            deliver(messages[at]);
        }
    }
    }
    #define RCLCPP_WARN_THROTTLE(logger, clock, ms, ...) \
        do { (void)(logger); (void)(clock); std::fprintf(stderr, __VA_ARGS__); } while (0)
    namespace std_msgs { namespace msg {
    struct Float64MultiArray { std::vector<double> data; };
    struct UInt8 { uint8_t data; void print() const { std::printf("status %d\n", data); } };
    } }
    namespace geometry_msgs { namespace msg {
    struct Vector3 { double x, y, z; };
    struct WrenchStamped {
        struct { rclcpp::Time stamp; std::string frame_id; } header;
        struct { Vector3 force, torque; } wrench;
        void print() const { std::printf("load %g %.17g %g\n", header.stamp.secs, wrench.force.x, wrench.torque.z); }
    };
    } }
"#;

/// Compiles the node and runs it: with ROS 2 if it is installed, and here against the declarations above. Only the two good messages
/// with a time that does not go back have a load.
#[test]
fn the_node_for_ros_2_publishes_no_stale_load() {
    if !is_there("g++", &["--version"]) {
        return;
    }
    let directory = tempfile::tempdir().unwrap();
    let mut arm = calibration(every_block(), Regressor::Linear);
    arm.gauges[1] = "*/ #error \\".to_owned();
    let all = [("arm", arm), ("warm", drifting(Regressor::Linear))];
    for (name, calibration) in all {
        write_calibration(&calibration, &directory.path().join(format!("{name}/"))).unwrap();
        let folder = directory.path().join(name);
        let n_inputs = calibration.gauges.len() + calibration.features.auxiliary.len();
        for header in [
            "rclcpp/rclcpp.hpp",
            "std_msgs/msg/float64_multi_array.hpp",
            "std_msgs/msg/u_int8.hpp",
            "geometry_msgs/msg/wrench_stamped.hpp",
        ] {
            let header = folder.join("stubs").join(header);
            fs::create_dir_all(header.parent().unwrap()).unwrap();
            fs::write(header, "#include <ros.hpp>\n").unwrap();
        }
        let ros = format!("#pragma once\n#define INPUTS {n_inputs}\n{ROS}");
        fs::write(folder.join("stubs/ros.hpp"), ros).unwrap();
        let program = folder.join("node");
        let mut compile = Command::new("g++");
        compile.args(["-std=c++17", "-Wall", "-Wextra", "-Werror", "-I"]).arg(folder.join("stubs"));
        compile.arg("-I").arg(folder.join("src")).arg("-o").arg(&program);
        succeed(compile.arg(folder.join("ros2/node.cpp")));
        let printed = succeed(&mut Command::new(&program));
        let times = printed.lines().filter_map(|line| line.strip_prefix("load "));
        let times: Vec<&str> = times.filter_map(|line| line.split(' ').next()).collect();
        assert_eq!(times, ["10", "10.15"], "{name}: {printed}");
        assert_eq!(printed.matches("status").count(), 4, "{name}: {printed}");
    }
}

#[test]
fn every_language_passes_its_own_test() {
    let directory = tempfile::tempdir().unwrap();
    let mut all = learned();
    all.push(("class".to_owned(), calibration(every_block(), Regressor::Linear)));
    all.extend(["numpy", "selftest"].map(|name| (name.to_owned(), drifting(Regressor::Linear))));
    all.push(("drifting".to_owned(), drifting(Regressor::Linear)));
    all.push(("warm_network".to_owned(), drifting(Regressor::Network)));
    for (name, calibration) in all {
        let folder = directory.path().join(&name);
        write_calibration(&calibration, &directory.path().join(format!("{name}/"))).unwrap();
        if is_there("python3", &["-c", "import numpy"]) {
            passes(Command::new("python3").arg("-B").arg(folder.join("python/selftest.py")), &name);
        }
        if is_there("octave-cli", &["--version"]) {
            passes(
                Command::new("octave-cli").arg("--norc").arg(folder.join("matlab/selftest.m")),
                &name,
            );
        }
        if is_there("rustc", &["--version"]) {
            let program = folder.join("selftest");
            let mut compile = Command::new("rustc");
            compile.args(["--edition", "2021", "-D", "warnings", "-o"]).arg(&program);
            succeed(compile.arg(folder.join("rust/selftest.rs")));
            passes(Command::new(program).arg(folder.join("expected.csv")), &name);
        }
    }
}

/// The test vector also has a channel outside its range, and a channel that is not a number, with unchanged gauges.
#[test]
fn a_library_tries_auxiliary_channels() {
    let directory = tempfile::tempdir().unwrap();
    write_calibration(&drifting(Regressor::Linear), &directory.path().join("warm/")).unwrap();
    let at = |name: &str| fs::read_to_string(directory.path().join("warm").join(name)).unwrap();
    let expected = at("expected.csv");
    assert!(expected.starts_with(
        "time,gauge_1,gauge_2,gauge_3,gauge_4,gauge_5,gauge_6,auxiliary_1,auxiliary_2,Fx,"
    ));
    assert!(expected.contains(",9,0\n") && expected.lines().nth(44).unwrap().ends_with(",32,0"));
    let header = at("src/warm.h");
    assert!(header.contains("#define WARM_AUXILIARY 2"));
    assert!(header.contains("[°C], trained from 15 to 35 °C"), "{header}");
}

/// The test vector has all statuses except "beyond". A second export is identical. Archive and folder have the same files.
#[test]
fn a_library_tests_pauses_tare_and_invalid_samples() {
    let directory = tempfile::tempdir().unwrap();
    // The status is "filling" until each gauge has travelled twice the largest radius.
    let every = every_block();
    let features = FeatureSettings { blocks: every.blocks.with(&Play, &[0.05]), ..every };
    let calibration = calibration(features, Regressor::Linear);
    let at = |name: &str| directory.path().join(name);
    write_calibration(&calibration, &at("arm/")).unwrap();
    let expected = fs::read_to_string(at("arm/expected.csv")).unwrap();
    for status in [0, 1, 3, 5, 16, 32] {
        assert!(expected.contains(&format!(",{status},0\n")), "status {status}");
    }
    for name in ["arm.zip", "second/arm.zip"] {
        fs::create_dir_all(at(name).parent().unwrap()).unwrap();
        write_calibration(&calibration, &at(name)).unwrap();
    }
    let bytes = fs::read(at("arm.zip")).unwrap();
    assert_eq!(bytes, fs::read(at("second/arm.zip")).unwrap());
    let mut zip = zip::ZipArchive::new(Cursor::new(bytes)).unwrap();
    assert_eq!(zip.len(), 19);
    for index in 0..zip.len() {
        let mut file = zip.by_index(index).unwrap();
        let mut content = String::new();
        file.read_to_string(&mut content).unwrap();
        let name = file.name().unwrap().into_owned();
        assert_eq!(content, fs::read_to_string(at(&name)).unwrap(), "{name}");
    }
}

#[test]
fn no_folder_is_written_over() {
    let directory = tempfile::tempdir().unwrap();
    let calibration = calibration(Default::default(), Regressor::Linear);
    let folder = directory.path().join("arm/");
    fs::create_dir(&folder).unwrap();
    fs::write(folder.join("mine.txt"), "mine").unwrap();
    let error = write_calibration(&calibration, &folder).unwrap_err();
    assert!(error.to_string().contains("folder"), "{error}");
    assert_eq!(fs::read_dir(&folder).unwrap().count(), 1);
    assert_eq!(fs::read_dir(directory.path()).unwrap().count(), 1);
}
