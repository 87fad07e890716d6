"""Recording: what the simulator sends and receives, as ROS 2 messages, in a bag that is never lost.

No ROS is needed here. The node publishes the very bytes that are logged. The whole interface::

    from rb_physics.recording import Recorder, RecordingError, load_topics, new_run_directory

    topics = load_topics()                        # msg_configs/topics.yaml; or load_topics(path)
    with Recorder(world, "recordings/run", scene=scene, topics=topics, rerun="file") as recorder:
        while world.time < 10.0:
            world.step()
            recorder.after_step()                 # logs hash, due outputs, snapshots

    # A node publishes what after_step returns: [(name, bytes), ...] of the topics that are due.
    for name, data in recorder.after_step():
        publishers[name].publish(data)            # one publisher per recorder.outputs.topics
    recorder.latched()                            # [(name, bytes), ...] of transient_local topics
    recorder.steps_until_due()                    # steps that may pass before the next output

    # Every change of the world goes through `perform`, which logs and does it, so that the run can
    # be repeated: operations.py lists them.
    recorder.perform("apply_wrench", body="box", force=(1, 0, 0), torque=(0, 0, 0), frame="world")
    recorder.perform("reset")

    recorder.write_input("/sim_node/bodies/box/wrench", data)   # a received message, as it came
    recorder.event("WARN", "wrench refused: unknown frame 'base'")   # a line for log and view
    recorder.counters                             # messages, bytes, dropped, queued, ...
    recorder.error                                # None, or why recording stopped (disk full …)

`Recorder(world, None, topics=topics)` records nothing and still returns the outputs: a node needs
no second path. Raises `RecordingError` (a ValueError with one clear sentence) when the folder
exists or can't be written, `TopicError` for a bad topics file.

All methods are called from the thread that steps the world.

======================  =========================================================================
cdr encoders decoders   messages as bytes; definitions: their types and type hashes
topics outputs          the topics table; the state of a world as (topic, bytes)
geometry markers urdf   what bodies look like; palette: colours and arrow lengths
operations              every change of a world from outside, as data; held_wrenches: what acts
message_queue mcap_log  the bag and its writer thread; mcap_writer: one file; rosbag2: what
                        makes it a bag
rerun_log               the view; rerun_shapes, _contacts, _applied, _plots: its entities;
                        rerun_blueprint: its layouts; rerun_batch, rerun_sink: how it is fed
recorder                all of it together
mcap_reader log_reader  one file, and a whole recording, read back; bag_folder: which files those are;
                        summary: for people; recover: a whole one from a torn one
recorded_run            what a log holds of a run; repetition: doing it again; replay: comparing it;
                        lost_spans: where something is missing
branch compare          going on from one of its moments, finding differences; motions: of what
tables export plot      columns for other tools; render: pictures of the view; new_path: where to
======================  =========================================================================
"""

from .errors import RecordingError
from .log_folder import new_run_directory
from .outputs import Outputs
from .recorder import Recorder
from .topics import Topic, TopicError, TopicTable, load_topics

__all__ = [
    "Outputs",
    "Recorder",
    "RecordingError",
    "Topic",
    "TopicError",
    "TopicTable",
    "load_topics",
    "new_run_directory",
]
