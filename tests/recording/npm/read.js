// node read.js FILE: decodes every message of an .mcap file as Foxglove does and prints, as JSON,
// per topic how many there were, the last one's time, and the last one itself.
import { readFile } from "node:fs/promises";
import { createRequire } from "node:module";

import { McapIndexedReader } from "@mcap/core";

const require = createRequire(import.meta.url);
const { loadDecompressHandlers } = require("@mcap/support");
const { parse } = require("@foxglove/rosmsg");
const { MessageReader } = require("@foxglove/rosmsg2-serialization");

const content = await readFile(process.argv[2]);
const readable = {
  size: async () => BigInt(content.byteLength),
  read: async (offset, size) => content.subarray(Number(offset), Number(offset + size)),
};
const reader = await McapIndexedReader.Initialize({
  readable,
  decompressHandlers: await loadDecompressHandlers(),
});
const readers = new Map();
const topics = {};
for await (const message of reader.readMessages()) {
  const channel = reader.channelsById.get(message.channelId);
  if (!readers.has(channel.schemaId)) {
    const schema = reader.schemasById.get(channel.schemaId);
    const text = new TextDecoder().decode(schema.data);
    readers.set(channel.schemaId, new MessageReader(parse(text, { ros2: true })));
  }
  const decoded = readers.get(channel.schemaId).readMessage(message.data);
  const found = (topics[channel.topic] ??= { count: 0 });
  found.count += 1;
  found.time = Number(message.logTime);
  found.last = decoded;
}
const plain = (_, value) =>
  typeof value === "bigint" ? value.toString() : ArrayBuffer.isView(value) ? [...value].map(String) : value;
console.log(JSON.stringify({ profile: reader.header.profile, topics }, plain));
