"""Writes one small recording in every format, into this folder or into FOLDER: python3 generate.py [FOLDER]

Needs NumPy and SciPy, and pyarrow for Parquet, mcap for MCAP, h5py for HDF5, openpyxl for .xlsx, xlwt and odfpy for .xls and .ods. Files of a missing
package are skipped and listed.
Sample k of 40 is at k / 64 s; gauge j is j + k / 4, and axis a is 10 a - k / 2. All these numbers are exact in every float type.
"""

import json
import struct
import sys
from pathlib import Path

import numpy as np

HERE = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
N = 40
K = np.arange(N, dtype=float)
TIME = K / 64
GAUGES = np.arange(1, 7) + K[:, None] / 4
LOADS = 10 * np.arange(1, 7) - K[:, None] / 2


def numpy_files():
    np.savez(
        HERE / "plain.npz",
        time=TIME,
        gauges=GAUGES.astype("<f4"),
        wrench=np.asfortranarray(LOADS),
        operator=np.array("somebody"),
        settings=np.array({"gain": 5}, dtype=object),
        rate=np.float64(64),
    )
    np.savez_compressed(
        HERE / "packed.npz",
        t_us=(TIME * 1e6).astype("<i8"),
        S=GAUGES.T.astype("<f2"),
        F=LOADS[:, :3].astype(">f8"),
        M=LOADS[:, 3:].astype(">f4"),
    )
    # The reference has its own clock at half the rate.
    np.savez(
        HERE / "two_clocks.npz",
        t=TIME,
        S=GAUGES,
        t_ref=TIME[::2],
        F=LOADS[::2, :3],
    )
    np.save(HERE / "lone.npy", np.column_stack([TIME, GAUGES, LOADS]))
    np.save(HERE / "records.npy", numpy_records("<f8"))
    np.savez(HERE / "records.npz", run=numpy_records("<M8[us]"), rate=np.float64(64))
    np.save(HERE / "objects.npy", np.array([{"a": 1}, None], dtype=object))


def numpy_records(time):
    wrench = np.dtype([("Fx", "<f8"), ("Mz", "<i4")])
    fields = [("label", "<U3"), ("t", time), ("gauges", ">f4", (6,)), ("wrench", wrench), ("is_on", "?"), ("legs", wrench, (2,))]
    records = np.zeros(N, dtype=np.dtype(fields, align=True))
    records["label"] = "é"
    records["t"] = TIME if time == "<f8" else (TIME * 1e6).astype("<i8").astype(time)
    records["gauges"] = GAUGES
    records["wrench"]["Fx"], records["wrench"]["Mz"] = LOADS[:, 0], 2 * LOADS[:, 5]
    return records


def json_lines():
    with open(HERE / "run.jsonl", "w") as file:
        for k in range(N):
            force, torque = dict(zip("xyz", LOADS[k, :3])), dict(zip("xyz", LOADS[k, 3:]))
            sample = {"t": TIME[k], "gauges": list(GAUGES[k]), "wrench": {"force": force, "torque": torque}}
            print(json.dumps({**sample, "note": "dry", "is_on": True}), file=file)


def matlab_files():
    from scipy.io import savemat

    variables = {
        "t": TIME[None, :],
        "gauges": GAUGES,
        "loads": LOADS,
        "counts": np.arange(N, dtype=np.uint16),
        "note": "dry run",
        "rig": {"name": "press", "gain": 5.0},
        "z": np.ones(N) * 1j,
    }
    savemat(HERE / "plain.mat", variables)
    savemat(HERE / "packed.mat", variables, do_compression=True)
    # Version 4 of the format has no structs.
    variables.pop("rig")
    savemat(HERE / "older.mat", variables, format="4")
    fields = {"t": TIME, "S": GAUGES, "out": {"loads": LOADS, "unit": "N"}, "note": "dry"}
    savemat(HERE / "struct.mat", {"run": fields, "gain": 5.0}, do_compression=True)
    runs = np.zeros(2, dtype=[("t", object), ("S", object), ("loads", object)])
    for k in range(2):
        rows = slice(None) if k == 0 else slice(0, 10)
        runs[k] = (TIME[rows], GAUGES[rows], LOADS[rows])
    savemat(HERE / "structs.mat", {"run": runs}, do_compression=True)


def hdf5_files():
    import h5py

    with h5py.File(HERE / "plain.h5", "w") as file:
        file["time"] = TIME
        file["gauges"] = GAUGES.astype("<f4")
        file["wrench"] = LOADS.astype(">f8")
        file["count"] = np.arange(N, dtype="i8")
        file["note"] = "dry run"
    with h5py.File(HERE / "chunked.h5", "w") as file:
        log = file.create_group("log/first")
        packed = dict(compression="gzip", shuffle=True)
        log.create_dataset("t", data=TIME, chunks=(16,), maxshape=(None,), **packed)
        log.create_dataset("S", data=GAUGES.astype("<f2"), chunks=(16, 4), **packed)
        log.create_dataset("F", data=(LOADS[:, :3] * 2).astype("<i2"), chunks=(16, 3), fletcher32=True)
        log["F"][:] = LOADS[:, :3] * 2
        log["loop"] = file["log"]
    record = [("t", "<f8"), ("gauges", "<f4", (6,)), ("Fx", "<f8"), ("Mz", ">f4"), ("label", "S5")]
    records = np.zeros(N, dtype=record)
    records["t"], records["gauges"] = TIME, GAUGES
    records["Fx"], records["Mz"] = LOADS[:, 0], LOADS[:, 5]
    with h5py.File(HERE / "records.h5", "w") as file:
        file.create_dataset("run", data=records, chunks=(10,), compression="gzip")
    # pandas stores a data frame in this form: names in one array, values in another.
    names = [b"t"] + [b"S%d" % j for j in range(1, 7)]
    with h5py.File(HERE / "frame.h5", "w") as file:
        file["df/block0_items"] = np.array(names)
        file["df/block0_values"] = np.column_stack([TIME, GAUGES])
    with h5py.File(HERE / "runs.h5", "w") as file:
        for name, n in (("first", 10), ("second", N)):
            file[f"{name}/t"] = TIME[:n]
            file[f"{name}/S"] = GAUGES[:n]
    # A logger declared these data but never wrote them: chunks at the end, some columns, and whole datasets of 0.8 GB each.
    with h5py.File(HERE / "gaps.h5", "w") as file:
        planned = {"t": (60,), "S": (60, 6), "F": (60, 3)}
        data = {
            name: file.create_dataset(name, shape, "f8", chunks=(10, 3)[: len(shape)], compression="gzip")
            for name, shape in planned.items()
        }
        data["t"][:50] = np.arange(50) / 64
        data["S"][:N], data["F"][:N] = GAUGES, LOADS[:, :3]
        data["S"][N : N + 10, :3] = 1.0
        for name, chunks in (("never", None), ("never_in_chunks", (1000,))):
            file.create_dataset(name, (100_000_000,), "f8", chunks=chunks)
    # MATLAB's option -v7.3 writes a user block in front, transposed arrays, and the class of each variable.
    path = HERE / "newer.mat"
    with h5py.File(path, "w", userblock_size=512) as file:

        def put(group, name, values, kind="double"):
            data = group.create_dataset(name, data=np.asarray(values).T)
            data.attrs["MATLAB_class"] = np.bytes_(kind)

        put(file, "t", TIME[None, :])
        put(file, "gauges", GAUGES)
        put(file, "loads", LOADS.astype("f4"), "single")
        put(file, "note", np.frombuffer("dry run".encode("utf-16le"), "u2")[None, :], "char")
        rig = file.create_group("rig")
        rig.attrs["MATLAB_class"] = np.bytes_("struct")
        put(rig, "gain", [[5.0]])
        put(file.create_group("#refs#"), "a", TIME[None, :])
    start = b"MATLAB 7.3 MAT-file, Platform: GLNXA64, Created on: no day HDF5 schema 1.00 ."
    content = bytearray(path.read_bytes())
    content[:128] = start.ljust(124, b" ") + b"\x00\x02IM"
    path.write_bytes(bytes(content))


def workbook_files():
    import datetime

    import openpyxl

    axes = ["Fx", "Fy", "Fz", "Mx", "My", "Mz"]
    book = openpyxl.Workbook()
    notes = book.active
    notes.title = "Notes"
    notes.append(["operator", "somebody"])
    sheet = book.create_sheet("Data")
    sheet.append(["Rig 5"])
    sheet.append([])
    sheet.append(["t", *(f"S{j}" for j in range(1, 7)), *axes, "label"])
    sheet.append(["[s]", *["mV/V"] * 6, *["N"] * 3, *["N·m"] * 3])
    for k in range(N):
        sheet.append([TIME[k], *GAUGES[k], *LOADS[k], "x"])
    other = book.create_sheet("Short")
    other.append(["t", "S1"])
    for k in range(5):
        other.append([k, k])
    book.save(HERE / "sheets.xlsx")
    book = openpyxl.Workbook()
    sheet = book.active
    sheet.append(["Zeit", "DMS 1", "Kraft z [N]"])
    start = datetime.datetime(2024, 3, 5, 23, 59, 59, 500000)
    for k in range(N):
        sheet.append([start + datetime.timedelta(seconds=k / 8), GAUGES[k, 0], LOADS[k, 0]])
    book.save(HERE / "dates.xlsx")


def other_workbooks():
    """Writes the sheet of dates.xlsx as a workbook of Excel 97 and as an OpenDocument spreadsheet."""
    import datetime

    import xlwt
    from odf.opendocument import OpenDocumentSpreadsheet
    from odf.table import Table, TableCell, TableRow
    from odf.text import P

    start = datetime.datetime(2024, 3, 5, 23, 59, 59, 500000)
    times = [start + datetime.timedelta(seconds=k / 8) for k in range(N)]
    heads = ["Zeit", "DMS 1", "Kraft z [N]"]
    book = xlwt.Workbook()
    sheet = book.add_sheet("Messung")
    for column, head in enumerate(heads):
        sheet.write(0, column, head)
    form = xlwt.easyxf(num_format_str="yyyy-mm-dd hh:mm:ss.000")
    for k, time in enumerate(times):
        # xlwt writes a date to the second only, so the number of days is written with the form of a date.
        sheet.row(k + 1).set_cell_number(0, (time - datetime.datetime(1899, 12, 30)) / datetime.timedelta(days=1), form)
        sheet.write(k + 1, 1, GAUGES[k, 0])
        sheet.write(k + 1, 2, LOADS[k, 0])
    book.save(str(HERE / "dates.xls"))
    book = OpenDocumentSpreadsheet()
    table = Table(name="Messung")
    row = TableRow()
    for head in heads:
        cell = TableCell(valuetype="string")
        cell.addElement(P(text=head))
        row.addElement(cell)
    table.addElement(row)
    for k, time in enumerate(times):
        row = TableRow()
        row.addElement(TableCell(valuetype="date", datevalue=time.isoformat(timespec="milliseconds")))
        for value in (GAUGES[k, 0], LOADS[k, 0]):
            row.addElement(TableCell(valuetype="float", value=str(value)))
        table.addElement(row)
    book.spreadsheet.addElement(table)
    book.save(str(HERE / "dates.ods"))


def labview_files():
    """Writes a file like LabVIEW's "Write To Measurement File", with decimal commas and a header for each of two segments."""

    def number(x):
        return f"{x:.6f}".replace(".", ",")

    lines = ["LabVIEW Measurement\t", "Writer_Version\t2", "Reader_Version\t2", "Separator\tTab"]
    lines += ["Decimal_Separator\t,", "Multi_Headings\tYes", "X_Columns\tNo", "Time_Pref\tRelative"]
    lines += ["***End_of_Header***\t", "\t"]
    for start in (0, 24):
        rows = range(start, 24 if start == 0 else N)
        tabs = "\t" * 7
        lines += ["Channels\t7" + tabs, "Samples" + f"\t{len(rows)}" * 7 + "\t"]
        lines += ["Date" + "\t2024/03/05" * 7 + "\t", "Time" + f"\t10:00:00,{15625 * start:06d}" * 7 + "\t"]
        lines += ["Y_Unit_Label" + "\tmV/V" * 6 + "\tN\t", "X_Dimension" + "\tTime" * 7 + "\t"]
        lines += ["X0" + "\t0,0000000000000000E+0" * 7 + "\t", "Delta_X" + "\t0,015625" * 7 + "\t"]
        names = "\t".join(f"S{j}" for j in range(1, 7))
        lines += ["***End_of_Header***" + tabs + "\t", f"X_Value\t{names}\tFx\tComment"]
        lines += ["\t" + "\t".join(number(x) for x in [*GAUGES[k], LOADS[k, 0]]) + "\t" for k in rows]
        lines += [""]
    (HERE / "segments.lvm").write_text("\r\n".join(lines), newline="")


def parquet_files():
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = {"time": pa.array((TIME * 1e9).astype("int64"), pa.timestamp("ns"))}
    for j in range(6):
        table[f"S{j + 1}"] = pa.array(GAUGES[:, j], pa.float32())
    for a, name in enumerate(("Fx", "Fy", "Fz", "Mx", "My", "Mz")):
        table[f"{name} [{'N' if a < 3 else 'N·m'}]"] = pa.array(LOADS[:, a])
    table["label"] = pa.array([f"run {k // 10}" for k in range(N)])
    table["pose"] = pa.array([[0.0, 1.0]] * N)
    table = pa.table(table)
    pq.write_table(table, HERE / "snappy.parquet", row_group_size=16)
    holes = [None if k in (3, 4) else float(j) for k, j in enumerate(GAUGES[:, 0])]
    with_holes = pa.table({"t_s": TIME, "S1": pa.array(holes), "Fx": LOADS[:, 0]})
    for codec in ("gzip", "lz4", "none", "zstd", "brotli"):
        pq.write_table(with_holes, HERE / f"{codec}.parquet", compression=codec)


def cdr(*parts):
    """Returns plain little-endian CDR. `parts` are format characters of `struct` with values, and each value is aligned to its size."""
    body = bytearray()
    for kind, value in parts:
        if kind == "text":
            data = value.encode() + b"\0"
            body += b"\0" * (-len(body) % 4) + struct.pack("<I", len(data)) + data
        else:
            size = struct.calcsize(kind)
            body += b"\0" * (-len(body) % size) + struct.pack("<" + kind, value)
    return b"\0\1\0\0" + bytes(body)


def header(secs):
    whole = int(secs)
    return [("i", whole), ("I", round((secs - whole) * 1e9)), ("text", "ft_link")]


def mcap_files():
    from mcap.writer import CompressionType, Writer

    def write(name, compression, wrench_every=1, others=()):
        with open(HERE / name, "wb") as file:
            writer = Writer(file, chunk_size=2048, compression=compression)
            writer.start()

            def channel(topic, kind):
                schema = writer.register_schema(kind, "ros2msg", b"")
                return writer.register_channel(topic, "cdr", schema)

            gauges = channel("/strain", "std_msgs/msg/Float64MultiArray")
            wrench = channel("/ft", "geometry_msgs/msg/WrenchStamped")
            joints = channel("/joints", "sensor_msgs/msg/JointState")
            text = channel("/note", "std_msgs/msg/String")
            more = [channel(topic, kind) for topic, kind in others]

            def add(topic, secs, data):
                nanosecs = round(secs * 1e9)
                writer.add_message(topic, nanosecs, data, nanosecs)

            for k in range(N):
                # A dimension of the layout consists of label, size and stride.
                layout = [("I", 1), ("text", "gauges"), ("I", 6), ("I", 6), ("I", 0)]
                numbers = [("I", 6)] + [("d", g) for g in GAUGES[k]]
                add(gauges, 1000 + TIME[k], cdr(*layout, *numbers))
                for topic, (_, kind) in zip(more, others):
                    stamped = header(1000 + TIME[k]) + [("d", -f) for f in LOADS[k]]
                    wrench_too = cdr(*stamped)
                    array_too = cdr(*layout, ("I", 6), *[("d", -g) for g in GAUGES[k]])
                    add(topic, 1000 + TIME[k], wrench_too if "Wrench" in kind else array_too)
                if k % wrench_every == 0:
                    # The log time is a second late, so a reader must use the time stamp in the message.
                    stamped = header(1000 + TIME[k]) + [("d", f) for f in LOADS[k]]
                    add(wrench, 1001 + TIME[k], cdr(*stamped))
                if k % 10 == 0:
                    names = [("I", 2), ("text", "a"), ("text", "b")]
                    lists = [("I", 2), ("d", 0.5), ("d", 1.5), ("I", 0), ("I", 0)]
                    add(joints, 1000 + TIME[k], cdr(*header(1000 + TIME[k]), *names, *lists))
                    add(text, 1000 + TIME[k], cdr(("text", "hello")))
            writer.finish()

    write("plain.mcap", CompressionType.NONE, wrench_every=2)
    write("zstd.mcap", CompressionType.ZSTD)
    write("lz4.mcap", CompressionType.LZ4)
    others = [
        ("/estimate", "geometry_msgs/msg/WrenchStamped"),
        ("/ati/wrench", "geometry_msgs/msg/WrenchStamped"),
        ("/temperatures", "std_msgs/msg/Float64MultiArray"),
    ]
    write("several.mcap", CompressionType.ZSTD, others=others)


makers = (numpy_files, json_lines, matlab_files, hdf5_files, workbook_files, other_workbooks, labview_files, parquet_files, mcap_files)
for make in makers:
    try:
        make()
    except ImportError as error:
        print(f"left out: {make.__name__}: {error}")
