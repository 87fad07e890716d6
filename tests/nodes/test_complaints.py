"""Warnings about refused messages: every text is told, floods are cut."""

from rb_physics_nodes.complaints import MOST_TEXTS, Complaints


def test_texts_are_told_once_and_floods_are_counted(monkeypatch):
    now = [0.0]
    monkeypatch.setattr("rb_physics_nodes.complaints.time.monotonic", lambda: now[0])
    told = []
    complain = Complaints(told.append)
    for _ in range(3):
        for frame in ("map", "odom", "base_link"):
            complain("wrench", frame)
    assert told == ["map", "odom", "base_link"]
    for i in range(100):
        complain("wrench", f"frame_{i}")
    assert len(told) == MOST_TEXTS
    complain("other", "map")
    assert told[-1] == "map"
    now[0] = 1.0
    complain("wrench", "map")
    left_out = 6 + 100 - (MOST_TEXTS - 3)
    assert told[-1] == f"map ({left_out} refused since the last line)"


def test_what_others_send_cannot_break_or_flood_a_line():
    said = []
    complain = Complaints(said.append)
    complain("topic", "no body 'a\n[ERROR] forged\x1b[31m'")
    assert said == [r"no body 'a\n[ERROR] forged\x1b[31m'"]
    complain("topic", "x" * 20_000)
    assert len(said[1]) < 1100
    assert said[1].endswith("… (20000 characters)")
