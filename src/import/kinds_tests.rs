//! A small file of each kind that people have, with made-up data: which roles its columns get, and what is asked.

use std::fmt::Write as _;

use super::tests::TestFile;
use super::*;
use crate::{
    import::{
        inspect::{Known, inspect},
        map::ColumnMap,
    },
    progress::Progress,
    recording::{Axis, Missing, Recording},
};

/// Returns the roles of the columns, in words.
fn roles(loaded: &Loaded) -> String {
    let roles: Vec<&str> = loaded.mapped.columns.iter().map(|column| column.is.name()).collect();
    roles.join(" ")
}

/// Reads a file, and checks that `inspect` proposes the same roles.
#[track_caller]
fn read_as(text: &str, expected: &str) -> Loaded {
    let file = TestFile::new(text);
    let loaded = file.read().unwrap();
    assert_eq!(roles(&loaded), expected, "{}", text.lines().next().unwrap_or_default());
    let inspection = inspect(&file.path, Known::Nothing, &Progress::default()).unwrap();
    let inspected: Vec<&str> = inspection.table.columns.iter().map(|own| own.is.name()).collect();
    assert_eq!(inspected.join(" "), expected);
    assert_eq!(inspection.check.error, None);
    // A fit also asks for the load of a signal that opens as it is.
    if loaded.recordings[0].missing() != Some(Missing::Load) || loaded.load_questions().count() > 0
    {
        assert_eq!(inspection.answer, loaded.asked().and_then(|asked| asked.1));
    }
    loaded
}

#[track_caller]
fn answered(text: &str, typed: &str) -> Loaded {
    let map = ColumnMap::typed(typed).unwrap();
    let loaded = read(&TestFile::new(text).path, Some(&map), &[], &Progress::default()).unwrap();
    assert_eq!(loaded.load_questions().next(), None, "{typed}");
    loaded
}

/// A table with this header and `n` rows, whose cells a function gives.
fn table(header: &str, n: u32, row: impl Fn(f64) -> Vec<f64>) -> String {
    let mut text = format!("{header}\n");
    for k in 0..n {
        let cells: Vec<String> = row(f64::from(k)).iter().map(f64::to_string).collect();
        writeln!(text, "{}", cells.join("\t")).unwrap();
    }
    text
}

#[track_caller]
fn assert_rate(recording: &Recording, hz: f64) {
    let rate = recording.rate_hz().unwrap();
    assert!((rate / hz - 1.0).abs() < 1e-6, "{rate} Hz");
}

/// Times are known by a unit of time or a word for a clock, and by values like a clock.
#[test]
fn a_time_has_any_name_and_unit() {
    for (name, step, hz) in [
        ("Zeit  1 - Standardmessrate [s]", 0.02, 50.0),
        ("Total Time (s)", 1.0, 1.0),
        ("abs time (s)", 0.001, 1000.0),
        ("Prüfzeit [s]", 0.1, 10.0),
        ("Time Elapsed (s)", 0.1, 10.0),
        ("Czas [s]", 0.1, 10.0),
        ("Time (min)", 0.05, 1.0 / 3.0),
        ("Laufzeit [h]", 0.001, 1.0 / 3.6),
        ("timestamp_start_us", 2_724_000.0, 1.0 / 2.724),
        ("A (ms)", 5.0, 200.0),
    ] {
        let text = table(&format!("{name}\tS1\tFz [N]"), 60, |k| {
            vec![12.0 + step * k, (k / 9.0).sin(), 5.0 * (k / 9.0).sin()]
        });
        let loaded = read_as(&text, "time gauge Fz");
        assert_eq!(loaded.recordings.len(), 1, "{name}");
        assert_eq!(loaded.recordings[0].n_samples(), 60);
        assert_rate(&loaded.recordings[0], hz);
    }
}

/// Counters, strains and loads that rise are no clocks. The order of the rows is then their order in time.
#[test]
fn what_only_rises_is_no_clock() {
    for (header, expected) in [
        ("N_cycles\tS1 [mV/V]\tForce (N)", "channel gauge Fz"),
        ("strain [-]\tS1\tforce [uN]", "channel gauge Fz"),
        ("Weight [kg]\tsignal\tlevel", "Fz gauge gauge"),
        ("index\tvoltage_V\tLoad (kN)", "channel gauge Fz"),
    ] {
        let text = table(header, 40, |k| vec![k, (k * k) % 7.0, k % 5.0 + 0.5 * k]);
        let loaded = read_as(&text, expected);
        assert!(loaded.recordings.iter().all(Recording::is_static), "{header}");
    }
}

/// A mark of missing values is left out where it is used, and noted once. The same number inside the range is a value.
#[test]
fn marks_of_missing_values_are_proposed_and_reported() {
    let is_noted = |loaded: &Loaded| {
        loaded.warnings.iter().filter(|own| own.to_string().contains("missing values")).count()
    };
    let wave = |k: f64| 1800.0 + (400.0 * (0.3 * k).sin()).round();
    let header = "timestamp,side,top";
    let rows = |mark: &dyn Fn(f64) -> f64| {
        table(header, 240, |k| vec![1_747_678_671.0 + 0.5 * k, wave(k), mark(k)]).replace('\t', ",")
    };
    let marked =
        read_as(&rows(&|k| if k % 5.0 == 2.0 { -1.0 } else { wave(k + 9.0) }), "time gauge gauge");
    assert_eq!(marked.recordings.iter().map(Recording::n_samples).sum::<usize>(), 192);
    let column = &marked.mapped.columns[2];
    assert_eq!((column.missing, column.min), (Some(-1.0), Some(1400.0)));
    assert_eq!((is_noted(&marked), marked.mapped.columns[1].missing), (1, None));
    let about_zero = read_as(&rows(&|k| (3.0 * (0.3 * k).sin()).round()), "time gauge gauge");
    assert_eq!((is_noted(&about_zero), about_zero.recordings[0].n_samples()), (0, 240));
    // A map that names the column keeps the mark; one that ignores it needs no row.
    let answer =
        answered(&rows(&|k| if k % 5.0 == 2.0 { -1e6 } else { wave(k + 9.0) }), "top=Fz N");
    assert_eq!(answer.recordings.iter().map(Recording::n_samples).sum::<usize>(), 192);
    assert!(answer.recordings[0].loads().iter().all(|load| *load > 0.0));
}

/// Numbers that rise by 1 or by 0.5 are a count under any name; the spread of values is no signal, but their mean is, even if it
/// never changes.
#[test]
fn counts_and_spreads_are_no_gauges() {
    let text = table("Zeit [s]\tSpannung\t循環\t半循環\tAblauf", 200, |k| {
        let halves = 0.5 * (k / 15.0).floor();
        vec![k, (k / 9.0).sin(), (k / 40.0).floor(), halves, 3.0 * (k / 20.0).floor()]
    });
    read_as(&text, "time gauge channel channel gauge");
    let text = table("timestamp_us\tmean_V\tstd_V\tn_samples", 60, |k| {
        vec![588_000.0 * k, 5.0, 0.001 * (k % 3.0), 20.0]
    });
    read_as(&text, "time gauge channel ignore");
}

#[test]
fn weights_against_readings_are_load_cases_in_newtons() {
    let text = "Mass_kg,Reading\n0,9100\n5,24400\n10,37100\n20,60200\n50,131000\n";
    let loaded = read_as(text, "Fz gauge");
    assert_eq!(loaded.recordings.len(), 5);
    let loads: Vec<f64> = loaded.recordings.iter().map(|own| own.loads()[0]).collect();
    assert!((loads[4] - 50.0 * 9.80665).abs() < 1e-9, "{loads:?}");
    // Without a unit, a mass is a question, and its answer is printed.
    let text = text.replace("Mass_kg", "Mass");
    let loaded = read_as(&text, "Fz gauge");
    assert_eq!(loaded.asked().and_then(|asked| asked.1).as_deref(), Some("Mass=Fz g"));
    let loaded = answered(&text, "Mass=Fz g");
    assert!((loaded.recordings[4].loads()[0] - 0.050 * 9.80665).abs() < 1e-12);
}

#[test]
fn every_unit_of_a_load_is_converted() {
    for (unit, newtons) in [
        ("kg", 9.80665),
        ("g", 0.009_806_65),
        ("t", 9806.65),
        ("lb", 4.448_221_615_260_5),
        ("oz", 0.278_013_850_953_781_2),
        ("kgf", 9.80665),
        ("lbf", 4.448_221_615_260_5),
        ("mN", 1e-3),
        ("µN", 1e-6),
        ("cN", 1e-2),
        ("daN", 10.0),
        ("kN", 1e3),
        ("MN", 1e6),
    ] {
        for header in [format!("t [s]\tS1\tForce ({unit})"), format!("t [s]\tS1\tKraft_{unit}")] {
            let text = table(&header, 20, |k| vec![0.1 * k, k % 7.0, 2.0 + k % 3.0]);
            let loaded = read_as(&text, "time gauge Fz");
            let load = loaded.recordings[0].loads()[0];
            assert!((load / newtons - 2.0).abs() < 1e-12, "{header}: {load}");
        }
    }
    let text = table("t [s]\tS1\tTorque (N·cm)", 20, |k| vec![0.1 * k, k % 7.0, 2.0 + k % 3.0]);
    let loaded = read_as(&text, "time gauge Mz");
    assert!((loaded.recordings[0].loads()[0] - 0.02).abs() < 1e-15);
}

/// A load in counts is never read as newtons without a word.
#[test]
fn a_load_in_counts_is_asked_for_its_unit() {
    let text = table("time_s\tS1\tFx\tTx", 60, |k| {
        vec![
            0.01 * k,
            (k / 9.0).sin(),
            (1e7 * (k / 9.0).sin()).round(),
            (3e5 * (k / 9.0).cos()).round(),
        ]
    });
    let loaded = read_as(&text, "time gauge Fx Mx");
    assert_eq!(loaded.asked().and_then(|asked| asked.1).as_deref(), Some("Fx=Fx N, Tx=Mx N·m"));
    let loaded = answered(&text, "Fx=Fx N/1000000, Tx=Mx N·m/1000000");
    let expected = (3e5 * (1.0_f64 / 9.0).cos()).round() / 1e6;
    assert!((loaded.recordings[0].loads()[3] - expected).abs() < 1e-9);
    let plain =
        table("time_s\tS1\tFx", 60, |k| vec![0.01 * k, (k / 9.0).sin(), 20.0 * (k / 9.0).cos()]);
    let loaded = read_as(&plain, "time gauge Fx");
    assert_eq!(
        (loaded.asked().and_then(|asked| asked.1), &loaded.mapped.without_unit[..]),
        (None, &["Fx".to_owned()][..])
    );
}

#[test]
fn gauges_are_known_by_what_they_are() {
    for name in [
        "Bx1",
        "taxel_3",
        "FSR1",
        "HX711",
        "Voltage",
        "AIN0",
        "CFT_raw_1",
        "load_cell_raw",
        "weight_raw",
        "a0",
    ] {
        let text =
            table(&format!("t [s]\t{name}\tKraft [N]"), 30, |k| vec![0.1 * k, k % 7.0, k % 5.0]);
        let loaded = read_as(&text, "time gauge Fz");
        assert_eq!(loaded.recordings[0].gauge_names(), [name]);
    }
}

/// A file with loads but no gauges opens, and so does a file with neither.
#[test]
fn a_table_without_gauges_or_loads_opens() {
    let text = table("Time_s\tFx\tFy\tFz\tTx\tTy\tTz", 50, |k| {
        vec![0.01 * k, 0.1 * k, k % 3.0, 0.5, 0.1, k % 2.0, 0.2]
    });
    let loaded = read_as(&text, "time Fx Fy Fz Mx My Mz");
    assert_eq!((loaded.recordings[0].n_gauges(), loaded.recordings[0].axes()), (0, &Axis::ALL[..]));
    let text = table("timestamp\tWave [m]\tRoll [deg]\tstress [MPa]", 50, |k| {
        vec![1.7e9 + 0.5 * k, k % 3.0, 0.5 * (k % 5.0), k % 2.0]
    });
    let loaded = read_as(&text, "time channel channel channel");
    assert_eq!(loaded.recordings[0].others().names(), ["Wave", "Roll", "stress"]);
    let loaded = read_as("2.5\n4.25\n5\n3.75\n1.25\n", "gauge");
    assert_eq!(loaded.recordings[0].gauges(), [2.5, 4.25, 5.0, 3.75, 1.25]);
    let loaded = answered("2.5\n4.25\n5\n3.75\n1.25\n", "sample_rate_hz=10");
    assert_rate(&loaded.recordings[0], 10.0);
    assert!(TestFile::new("Dear diary,\ntoday I measured.\n").read().is_err());
}

/// A table that goes up and down on one axis keeps the order of its rows; a shuffled one is a list of load cases.
#[test]
fn the_order_of_rows_tells_the_branch_of_a_load_that_goes_up_and_down() {
    let loads: Vec<u32> = (0..10).chain((0..10).rev()).chain(0..10).collect();
    let rows = |loads: &[u32]| -> String {
        let rows = loads.iter().map(|load| format!("{},{load}\n", f64::from(*load) * 1.5));
        format!("S1 [mV/V],Fz [N]\n{}", rows.collect::<String>())
    };
    let ordered = read_as(&rows(&loads), "gauge Fz");
    assert_eq!(ordered.recordings.len(), 1);
    assert!(!ordered.recordings[0].is_load_case());
    let shuffled: Vec<u32> = (0..21).map(|k| k * 8 % 21).collect();
    let shuffled = read_as(&rows(&shuffled), "gauge Fz");
    assert_eq!(shuffled.recordings.len(), 21);
    assert!(shuffled.recordings[0].is_load_case());
    let rising = read_as(&rows(&(0..21).collect::<Vec<_>>()), "gauge Fz");
    assert_eq!(rising.recordings.len(), 21);
}

#[test]
fn quaternions_of_a_robot_are_a_pose() {
    let text = table("time_s\tqx\tqy\tqz\tqw\tFx [N]\tFy [N]\tFz [N]", 20, |k| {
        vec![0.1 * k, (k / 20.0).sin(), 0.0, 0.0, (k / 20.0).cos(), k, 1.0, 2.0 * k]
    });
    read_as(&text, "time pose_qx pose_qy pose_qz pose_qw Fx Fy Fz");
    let text = table(
        "timestamp\tactual_TCP_pose_0\tactual_TCP_pose_1\tactual_TCP_pose_2\tactual_TCP_pose_3\tactual_TCP_pose_4\tactual_TCP_pose_5\tS1",
        20,
        |k| vec![0.1 * k, k, 1.0, 2.0, 0.1 * k, 0.2, 0.3, k % 5.0],
    );
    read_as(&text, "time pose_x pose_y pose_z pose_rx pose_ry pose_rz gauge");
}

/// The header of a preamble that is as wide as the table, over blank cells, with equal names.
#[test]
fn headers_are_found_from_the_numbers_below() {
    let mut text = String::from(
        "Acme Export\nDevice:\tA\tA\tB\tB\nSamples (#):\t60\t60\t60\t60\nRate (Hz):\t10.0\t10.0\t10.0\t10.0\nGain:\t1.0\t1.0\t1.0\t1.0\n\
         abs time (s)\tFx\tFz\tFx\tFz\n\tN\tN\tN\tN\n",
    );
    for k in 0..60 {
        writeln!(text, "{}.{}\t{k}.5\t{}\t{k}.25\t{}", k / 10, k % 10, k % 7, k % 5).unwrap();
    }
    let loaded = read_as(&text, "time Fx Fz channel channel");
    assert_eq!(loaded.recordings[0].n_samples(), 60);
    assert_rate(&loaded.recordings[0], 10.0);
    let mut text = String::from("N_cycles,Machine_Load,Machine_Displacement,crack,temp_grip\n");
    for k in 1..60 {
        let (crack, temp) = if k % 20 == 0 { ("0.5", "21") } else { ("", "") };
        writeln!(text, "{k},6.{k},3.{k},{crack},{temp}").unwrap();
    }
    let loaded = TestFile::new(&text).read().unwrap();
    assert_eq!(loaded.mapped.columns[1].header, "Machine_Load");
    assert_eq!(loaded.recordings[0].axes(), [Axis::Fz]);
    let loaded = read_as("t [s]\tS1 [V]\tS1 [V]\n0\t1\t2\n1\t2\t3\n2\t3\t5\n", "time gauge gauge");
    assert_eq!(loaded.recordings[0].gauge_names(), ["S1", "S1 (2)"]);
}

/// Date and clock in two columns, in any order, without a header.
#[test]
fn a_clock_and_a_date_are_one_time() {
    let rows =
        (0..40).map(|k| format!("\"17:10:{:02}\",\"2026-03-24\",17{}.4,\"Pa\"\n", k / 2, k % 7));
    let loaded = read_as(&rows.collect::<String>(), "time date gauge ignore");
    assert_eq!(loaded.recordings[0].duration_secs(), 19.0);
}

/// An answer changes what it names; everything else keeps its proposal.
#[test]
fn what_an_answer_leaves_out_keeps_its_proposal() {
    let text =
        "MD;UL;UD\n0.0;-0.110;0.190\n0.0682;-0.070;0.510\n0.1816;-0.010;1.050\n0.295;0.040;1.580\n";
    let loaded = read_as(text, "gauge gauge gauge");
    assert!(loaded.asked().and_then(|asked| asked.1).is_some());
    assert_eq!(roles(&answered(text, "MD=Fz kg")), "Fz gauge gauge");
    assert_eq!(roles(&answered(text, "1=Fz kg, UD=ignore")), "Fz gauge ignore");
    let wrong = ColumnMap::typed("MX=Fz kg").unwrap();
    assert!(read(&TestFile::new(text).path, Some(&wrong), &[], &Progress::default()).is_err());
}

/// Checks the largest load (N) of all recordings.
#[track_caller]
fn assert_largest(loaded: &Loaded, newtons: f64) {
    let loads = loaded.recordings.iter().flat_map(|own| own.loads().to_vec());
    let largest = loads.fold(0.0, f64::max);
    assert!((largest - newtons).abs() < 1e-9, "{largest}");
}

/// A units row wins over brackets in the header, and a word in brackets that is no unit belongs to the name.
#[test]
fn brackets_without_a_unit_belong_to_the_name() {
    let units = "t\tLoad (filtered)\tS1 (corrected)\n(s)\t(kN)\t(mV)\n";
    let rows = "0\t1\t0.1\n0.1\t2\t0.2\n0.2\t3\t0.3\n0.3\t1\t0.41\n";
    let loaded = read_as(&format!("{units}{rows}"), "time Fz gauge");
    assert_eq!(loaded.mapped.columns[1].name, "Load (filtered)");
    assert_eq!(loaded.recordings[0].loads()[1], 2000.0);
    let loaded = read_as(&format!("t\tLoad (filtered)\tS1\n{rows}"), "time Fz gauge");
    assert_eq!(loaded.asked().unwrap().1.as_deref(), Some("Load (filtered)=Fz N"));
}

/// The unit of a channel in the header of a LabVIEW file wins over brackets in its name.
#[test]
fn labview_gives_the_units_of_its_channels() {
    let text = "LabVIEW Measurement\nSeparator\tTab\nX_Columns\tOne\n***End_of_Header***\n\nChannels\t2\n\
        Y_Unit_Label\tNewtons\tVolts\n***End_of_Header***\n\
        X_Value\tExcitation (Trigger)\tBridge (Left)\tComment\n0\t1\t0.5\n0.1\t2\t0.7\n0.2\t4\t0.6\n";
    let loaded = read_as(text, "time Fz gauge");
    assert_eq!(loaded.recordings[0].loads(), [1.0, 2.0, 4.0]);
}

/// Tables side by side, each with its clock: one is read, and a column that the user names is read with its clock.
#[test]
fn a_load_has_the_clock_of_its_table() {
    let mut text =
        String::from("Time [s],Force [N],Bridge [mV/V],Time [s],Force [N],Bridge [mV/V]\n");
    for k in 0..8 {
        let first = if k < 5 { format!("0.{k},{},0.{k}", k % 3) } else { ",,".to_owned() };
        writeln!(text, "{first},{k}.5,{},1.{k}", k % 4).unwrap();
    }
    let loaded = read_as(&text, "time Fz gauge ignore ignore ignore");
    assert_eq!((loaded.recordings[0].n_samples(), loaded.recordings[0].duration_secs()), (5, 0.4));
    assert!(!loaded.warnings.is_empty());
    let loaded = answered(&text, "5=Fz N");
    assert_eq!(roles(&loaded), "ignore ignore ignore time Fz gauge");
    assert_eq!((loaded.recordings[0].n_samples(), loaded.recordings[0].duration_secs()), (8, 7.0));
}

/// Parts of names, and foreign units behind them, are no loads; a name with Mz is a moment.
#[test]
fn parts_of_names_are_no_loads() {
    for (name, role) in [
        ("TX_VGA_dB", "channel"),
        ("tx_bytes", "channel"),
        ("my value", "gauge"),
        ("Fy idx", "channel"),
        ("Mz_motor", "Mz"),
        ("Thrust (g)", "Fz"),
        ("grams", "Fz"),
        ("kg", "Fz"),
        ("ft-lb", "Mz"),
        ("factor_N_per_mm", "channel"),
        ("Strain (%)", "gauge"),
        ("Strain 1 (%)", "gauge"),
        ("strain [-]", "gauge"),
        ("stress", "channel"),
        ("actual_execution_time", "channel"),
    ] {
        let text =
            table(&format!("t [s]\traw\t{name}"), 30, |k| vec![0.1 * k, k % 7.0, (k * 3.0) % 8.0]);
        let loaded = TestFile::new(&text).read().unwrap();
        assert!(roles(&loaded).ends_with(role), "{name}: {}", roles(&loaded));
    }
    let text = table("kg\tcounts", 8, |k| vec![k % 5.0, 8388.0 + 991.0 * (k % 5.0)]);
    let loaded = read_as(&text, "Fz gauge");
    assert_largest(&loaded, 4.0 * 9.806_65);
    let text = table("u_tr\tu\tF", 40, |k| vec![k % 9.0, k % 20.0, (k * 7.0) % 31.0]);
    assert_eq!(read_as(&text, "gauge gauge gauge").asked().unwrap().1.as_deref(), Some("F=Fz N"));
}

/// The controllers of UR number the parts of the wrench; the moments of the joints are no load.
#[test]
fn the_wrench_of_a_ur_robot_is_known() {
    let names: Vec<String> = (0..6).map(|k| format!("actual_TCP_force_{k}")).collect();
    let text = table(&format!("timestamp\ttarget_moment_0\t{}", names.join("\t")), 20, |k| {
        (0..8).map(|n| if n == 0 { 0.1 * k } else { (k + f64::from(n)) % 5.0 }).collect()
    });
    read_as(&text, "time channel Fx Fy Fz Mx My Mz");
}

/// Lines above the table give the unit of its load, and its sample rate.
#[test]
fn a_unit_above_the_table_is_used() {
    let loaded =
        read_as("# unit: kg\n# rate: 80 Hz\nload,raw\n1,8000\n2,9001\n1,8003\n", "Fz gauge");
    assert!((loaded.recordings[0].loads()[1] - 2.0 * 9.806_65).abs() < 1e-9);
    assert_rate(&loaded.recordings[0], 80.0);
    let rows: String = (0..20).map(|k| format!("0.{}\n", k % 7)).collect();
    let loaded = read_as(&format!("15.05.22\nLogNo=002\nUnit=kN\nSpeed=1280\n{rows}"), "Fz");
    assert_largest(&loaded, 600.0);
}

/// A first column that rises in every row is the time, though its steps vary and it starts below zero.
#[test]
fn an_uneven_clock_without_a_name_is_found() {
    let mut time = -0.014;
    let rows = (0..40).map(|k| {
        time += [0.002, 0.016, 0.04, 0.011][k % 4];
        format!("{time:.6}\t{}\n", (k * 5) % 13)
    });
    read_as(&rows.collect::<String>(), "time gauge");
    // Load cases that are written by hand rise too.
    read_as("0\t0.1\n1\t0.3\n2\t0.2\n5\t0.6\n10\t0.9\n", "gauge gauge");
}

/// A second table below a blank line is not part of the first one, and a row number with a point is no gauge.
#[test]
fn a_table_ends_where_another_one_begins() {
    let mut text = String::from("<poses>\n");
    (1..25).for_each(|k| writeln!(text, "{k}. {}.5 0.{k} -1.{k}", k % 5).unwrap());
    text.push_str("\n\n<matrices>\n");
    (1..25).for_each(|k| writeln!(text, "r{k}. [0 0 1][1 0 0]").unwrap());
    let loaded = read_as(&text, "channel gauge gauge gauge");
    let n_samples: usize = loaded.recordings.iter().map(Recording::n_samples).sum();
    assert_eq!(n_samples, 24);
}

/// A sample rate in a line of its own between units and numbers does not hide the header.
#[test]
fn a_lone_word_below_the_units_is_no_header() {
    let mut text = String::from(
        "Export V5\nFile: a.bin\n\nTime 1\tDMS_1\tKraft Ref\ns\tmV/V\tN\n300 Hz\t\t\n",
    );
    for k in 10..40 {
        writeln!(text, "0,{k}\t0,{}\t{},25", k % 7, k % 5).unwrap();
    }
    let loaded = TestFile::new(&text).read().unwrap();
    assert_eq!(roles(&loaded), "time gauge Fz");
    assert_eq!(loaded.recordings[0].gauge_names(), ["DMS_1"]);
    assert_eq!(loaded.recordings[0].n_samples(), 30);
}

/// Empty cells at the end of a row are no fault, and `hh:mm:ss` is a unit of time.
#[test]
fn empty_cells_at_the_end_are_silent() {
    let text = "Elapsed (hh:mm:ss);F [N];S1;\n00:00:00;1;2;\n00:00:01;2;3;\n00:00:02;3;5;\n";
    let loaded = read_as(text, "time Fz gauge ignore");
    assert_eq!((loaded.recordings[0].duration_secs(), loaded.warnings.len()), (2.0, 0));
}

/// A known unit in brackets counts wherever it stands in the name, and a number behind a unit tells equal columns apart.
#[test]
fn a_unit_within_a_name_is_the_unit() {
    for (name, newtons) in [
        ("Force (kN) Run #1", 1e3),
        ("Force_kN_1", 1e3),
        ("Load(kgf)_1", 9.806_65),
        ("Kraft [kN] Kanal 1", 1e3),
        ("Сила, кН", 1e3),
    ] {
        let text = table(&format!("Time (s) Run #1\t{name}\tBridge (mV) Run #1"), 40, |k| {
            vec![0.1 * k, (k % 7.0) + 0.5, (k * k) % 11.0]
        });
        let loaded = read_as(&text, "time Fz gauge");
        assert_eq!(loaded.recordings[0].loads()[1], 1.5 * newtons, "{name}");
    }
    // A coefficient is no centinewton.
    let text = table("alpha\tCn\tS1", 40, |k| vec![(k * 3.0) % 5.0, 0.0, (k * k) % 7.0]);
    assert_eq!(read_as(&text, "channel ignore gauge").mapped.questions, []);
}

/// Names such as `Unnamed: 0` are no note above the table, and a short header names the first columns.
#[test]
fn headers_of_other_programs_are_found() {
    let row = |k: f64| vec![k, 0.1 * k, (k % 7.0) + 0.5, (k * k) % 11.0];
    let commas = |text: String| text.replace('\t', ",");
    for name in ["Unnamed: 0", "Ch: 3"] {
        let text = commas(table(&format!("{name}\tt [s]\tForce [N]\tRaw"), 80, row));
        assert_eq!(read_as(&text, "channel time Fz gauge").recordings[0].loads()[1], 1.5);
    }
    let text = commas(table("Sequence\tSample Number\tTime", 80, |k| {
        vec![k % 2.0, k, 0.1 * k, (k % 7.0) + 0.5, (k * k) % 11.0]
    }));
    assert_rate(&read_as(&text, "channel channel time gauge gauge").recordings[0], 10.0);
    let text = "Run\tTime\tAlpha\tB1\tB2\n/\tH:M:S\tdegrees\tsteps\tsteps\n".to_owned()
        + &(0..40)
            .map(|k| format!("{k}\t13:31:{k:02}\t{}\t{}\t{}\n", k % 3, (k * k) % 7, (k * k) % 11))
            .collect::<String>();
    let loaded = read_as(&text, "channel time channel gauge gauge");
    assert_eq!(loaded.recordings[0].gauge_names(), ["B1", "B2"]);
    assert_rate(&loaded.recordings[0], 1.0);
}

/// A stamp, a column in milliseconds and a constant are not the gauges or the clock that their names suggest.
#[test]
fn clocks_are_no_gauges() {
    let epoch = |k: f64| 1_770_048_075.0 + 0.1 * k;
    let text = table("UnixTimestamp\tRaw\tForce_N", 40, |k| vec![epoch(k), k % 7.0, k % 5.0]);
    assert_rate(&read_as(&text, "time gauge Fz").recordings[0], 10.0);
    let text = table("host_ts_ms\tch0\tForce_N", 40, |k| {
        vec![1e3 * epoch((k / 5.0).floor()), k % 7.0, k % 5.0]
    });
    read_as(&text, "channel gauge Fz");
    let text =
        table("Microseconds\tt [s]\tRaw\tForce_N", 40, |k| vec![200.0, 0.1 * k, k % 7.0, k % 5.0]);
    assert_rate(&read_as(&text, "ignore time gauge Fz").recordings[0], 10.0);
}

#[test]
fn trials_are_groups_and_a_nul_ends_a_line() {
    let text = table("trial\tt [s]\tRaw\tForce_N", 80, |k| {
        vec![(k / 20.0).floor(), 0.1 * k, k % 7.0, k % 5.0]
    });
    read_as(&text, "group time gauge Fz");
    let text = table("t [s]\tRaw\tForce_N", 40, |k| vec![0.1 * k, k % 7.0, k % 5.0]);
    let blanks = " ".repeat(100) + "\t";
    let loaded = read_as(&text.replace('\n', "\0\n").replace('\t', &blanks), "time gauge Fz");
    assert_eq!(loaded.recordings[0].loads()[3], 3.0);
}

/// Labels in front of the numbers are the names of columns, and units behind the numbers are theirs, in one line or in several.
#[test]
fn labels_in_each_line_name_the_columns() {
    let lines = |line: &dyn Fn(f64) -> String| -> String {
        let all = (0..60).map(|k| line(f64::from(k)) + "\n");
        "HX711 started\nTare: 8388\n".to_owned() + &all.collect::<String>()
    };
    let wave = |k: f64| (k % 9.0 - 4.0) / 4.0;
    let pairs = lines(&|k| format!("t:{} ax:{} Force = {} kN", 0.1 * k, wave(k), 2.0 * wave(k)));
    let loaded = read_as(&pairs, "time gauge Fz");
    assert_rate(&loaded.recordings[0], 10.0);
    assert_largest(&loaded, 2000.0);
    let of_scale = lines(&|k| format!("Weight: {} g", 100.0 * wave(k)));
    assert_eq!(read_as(&of_scale, "Fz").recordings[0].n_samples(), 60);
    let stamped = lines(&|k| format!("12:03:{:02}.000 -> Weight: {k} kg", k));
    assert_rate(&read_as(&stamped, "time Fz").recordings[0], 1.0);
    let blocks = lines(&|k| format!("ADC:{}\nFiltered force: {} N\n", 7.0 * wave(k), wave(k)));
    let loaded = read_as(&blocks, "gauge Fz");
    assert_eq!(loaded.recordings.iter().map(Recording::n_samples).sum::<usize>(), 60);
}

/// A file may hold one row for each channel, or the channels of a sample in successive rows.
#[test]
fn rows_of_channels_become_columns() {
    let row = |name: &str, value: &dyn Fn(f64) -> f64| -> String {
        let values: Vec<String> = (0..60).map(|k| value(f64::from(k)).to_string()).collect();
        format!("{name},{}\n", values.join(","))
    };
    let wave = |k: f64| (k % 9.0 - 4.0) / 4.0;
    let turned =
        row("t [s]", &|k| 0.01 * k) + &row("S1", &wave) + &row("Fz [N]", &|k| 5.0 * wave(k));
    let loaded = read_as(&turned, "time gauge Fz");
    assert_rate(&loaded.recordings[0], 100.0);
    assert_largest(&loaded, 5.0);
    let long = |clock: &dyn Fn(f64) -> f64, names: [&str; 2]| -> String {
        let rows = (0..60).map(f64::from).map(|k| {
            let [first, second] = names;
            format!("{},{first},{}\n{},{second},{}\n", clock(k), wave(k), clock(k), 5.0 * wave(k))
        });
        "time [s],channel,value\n".to_owned() + &rows.collect::<String>()
    };
    let loaded = read_as(&long(&|k| 0.1 * k, ["S1", "Fz"]), "time gauge Fz");
    assert_rate(&loaded.recordings[0], 10.0);
    assert_largest(&loaded, 5.0);
    read_as(&long(&|k| 0.1 * k, ["1", "2"]), "time gauge gauge");
}

/// The rows of one sensor follow those of another one. Only the user knows whether they are one sensor.
#[test]
fn several_sensors_in_one_column_are_a_question() {
    let rows = |sensor: &str| -> String {
        (0..60).map(|k| format!("{},{sensor},{}\n", 0.1 * f64::from(k), k % 7)).collect()
    };
    let text = "time [s],device,raw\n".to_owned() + &rows("left") + &rows("right");
    let loaded = TestFile::new(&text).read().unwrap();
    assert_eq!(loaded.asked().unwrap().1.as_deref(), Some("device=group"));
    assert_eq!(answered(&text, "device=group").recordings.len(), 2);
}

/// Results of a test may stand above its data, with names of their own.
#[test]
fn the_longest_of_several_tables_is_read() {
    let results = "Results\nNo,Max force,Strain\n,(N),(%)\n1,120,3\n2,130,4\n3,125,5\n4,110,5\n\n";
    let rows: String =
        (0..60).map(|k| format!("{},{},{}\n", 0.1 * f64::from(k), k % 7, k % 5)).collect();
    let text = format!("{results}Time,Extension,Load\n(s),(mm),(kN)\n{rows}");
    let loaded = read_as(&text, "time channel Fz");
    assert_eq!(loaded.recordings[0].n_samples(), 60);
    // A logger that starts anew repeats its names.
    let again = "time,S1,Fz\n0,1,2\n1,2,3\n2,1,3\ntime,S1,Fz\n0,1,2\n1,2,3\n2,1,3\n3,2,4\n";
    assert_eq!(read_as(again, "time gauge Fz").recordings.len(), 2);
}

/// A clock may pass midnight, and the first column may lack a name. A title is no name of a column.
#[test]
fn clocks_without_a_date_or_a_name_are_found() {
    let rows: String = (0..40)
        .map(|k| {
            format!("{:02}:{:02}:00;{}\n", (23 + (k + 40) / 60) % 24, (k + 40) % 60, k * k % 7)
        })
        .collect();
    for header in ["", "Uhrzeit;Kanal 1\n"] {
        let loaded = read_as(&format!("{header}{rows}"), "time gauge");
        assert_eq!(loaded.recordings.len(), 1);
        assert_rate(&loaded.recordings[0], 1.0 / 60.0);
    }
    let nameless = table("\tsignal", 60, |k| vec![0.25 * k, (k / 9.0).sin()]);
    assert_rate(&read_as(&nameless, "time gauge").recordings[0], 4.0);
    let one: String = (0..40).map(|k| format!("{}\n", k * k % 7)).collect();
    read_as(&format!("Readings of the load cell\n{one}"), "gauge");
    let three = table("Sample 7", 40, |k| vec![0.1 * k, k * k % 7.0, k % 5.0]).replace('\t', ",");
    read_as(&three, "time gauge gauge");
    let counted = table("Count\tsignal", 40, |k| vec![3.0 * k, (k / 9.0).sin()]);
    read_as(&counted, "channel gauge");
}
