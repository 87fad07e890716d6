"""A flipped bit in the first chunk, which says what the channels are, left nothing to recover, although
the end of the file says it again."""

import rb_physics as rb
from rb_physics.recording import Recorder
from rb_physics.recording.log_reader import Recording
from rb_physics.recording.mcap_reader import read_summary
from rb_physics.recording.recover import recover


def test_the_other_chunks_are_recovered(tmp_path) -> None:
    world = rb.World(dt=1e-3)
    world.add_body(rb.HalfSpace((0, 0, 1), 0.0), type="static", name="ground")
    world.add_body(rb.Sphere(0.1), mass=1.0, name="ball", position=(0, 0, 1))
    with Recorder(world, tmp_path / "run", chunk_bytes=40000) as recorder:
        for _ in range(2000):
            world.step()
            recorder.after_step()
    before = sum(1 for _ in Recording(tmp_path / "run").messages())
    (bag,) = (tmp_path / "run").glob("*.mcap")
    with open(bag, "rb") as file:
        assert len(read_summary(file).chunks) > 1
        place = read_summary(file).chunks[0]
    data = bytearray(bag.read_bytes())
    data[place.offset + place.length // 2] ^= 1
    bag.write_bytes(data)
    saved = recover(tmp_path / "run")
    assert saved.damaged_chunks == 1
    assert before // 4 < saved.messages < before
