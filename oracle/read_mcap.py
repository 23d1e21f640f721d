"""Reads an MCAP file of `sidestep plan --out` with the mcap project's own reader and ROS 2 decoder; prints what is in it as JSON.

Needs: pip install mcap mcap-ros2-support
"""

import json
import sys

from mcap.reader import make_reader
from mcap_ros2.decoder import DecoderFactory

with open(sys.argv[1], "rb") as file:
    reader = make_reader(file, decoder_factories=[DecoderFactory()])
    summary = reader.get_summary()
    found = {"messages": summary.statistics.message_count, "topics": {}}
    for schema, channel, message, decoded in reader.iter_decoded_messages():
        topic = found["topics"].setdefault(channel.topic, {"type": schema.name, "count": 0})
        topic["count"] += 1
        topic["frame"] = decoded.header.frame_id
        if channel.topic == "/map":
            info = decoded.info
            topic |= {"width": info.width, "height": info.height, "resolution": info.resolution}
            topic["occupied"] = sum(1 for cell in decoded.data if cell == 100)
            topic["origin"] = [info.origin.position.x, info.origin.position.y]
        else:
            topic["poses"] = [
                [p.pose.position.x, p.pose.position.y, p.pose.orientation.z, p.pose.orientation.w, p.header.stamp.sec + 1e-9 * p.header.stamp.nanosec]
                for p in decoded.poses
            ]
    print(json.dumps(found))
