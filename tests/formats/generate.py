"""Makes one small recording in every format, in this folder or the one named: python3 generate.py [FOLDER]

Needs NumPy and SciPy; pyarrow for Parquet, mcap for MCAP: without one of them its files are left out and named.
Sample k of 40 stands at k / 64 s; gauge j is j + k / 4, axis a is 10 a - k / 2. All of these are exact in any float.
"""

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
    # The reference on its own clock, half as often.
    np.savez(
        HERE / "two_clocks.npz",
        t=TIME,
        S=GAUGES,
        t_ref=TIME[::2],
        F=LOADS[::2, :3],
    )
    np.save(HERE / "lone.npy", np.column_stack([TIME, GAUGES, LOADS]))
    np.save(HERE / "objects.npy", np.array([{"a": 1}, None], dtype=object))


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
    """Plain CDR, low byte first: formats of struct with their values, each aligned to its size."""
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

    def write(name, compression, wrench_every=1):
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

            def add(topic, secs, data):
                nanosecs = round(secs * 1e9)
                writer.add_message(topic, nanosecs, data, nanosecs)

            for k in range(N):
                # One dimension of the layout: its label, size and stride.
                layout = [("I", 1), ("text", "gauges"), ("I", 6), ("I", 6), ("I", 0)]
                numbers = [("I", 6)] + [("d", g) for g in GAUGES[k]]
                add(gauges, 1000 + TIME[k], cdr(*layout, *numbers))
                if k % wrench_every == 0:
                    # Logged a second late: the stamp counts.
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


for make in (numpy_files, matlab_files, parquet_files, mcap_files):
    try:
        make()
    except ImportError as error:
        print(f"left out: {make.__name__}: {error}")
