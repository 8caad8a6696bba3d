// Unpacks what replay_data.py packed: typed arrays of the base surface, and every field of every frame.

const FLOATS = 3, CORNERS = 3;

async function inflate(packed) {
  const stream = new Blob([packed]).stream().pipeThrough(new DecompressionStream("gzip"));
  return new Uint8Array(await new Response(stream).arrayBuffer());
}

// Planes are differences to the plane before, low bytes before high bytes; typed arrays wrap around as numpy does.
function planesOf(bytes, start, { planes, size }, length) {
  const Kind = size === 1 ? Uint8Array : Uint16Array;
  let before = new Kind(length);
  return Array.from({ length: planes }, (_, place) => {
    const plane = new Kind(length), low = start + place * length * size, high = low + length;
    for (let i = 0; i < length; i++) plane[i] = before[i] + bytes[low + i] + (size === 1 ? 0 : bytes[high + i] << 8);
    return (before = plane);
  });
}

export async function unpack(header, packed) {
  const bytes = await inflate(packed), count = header.vertices;
  const positions = new Float32Array(bytes.buffer, 0, count * FLOATS);
  const normals = new Float32Array(bytes.buffer, positions.byteLength, count * FLOATS);
  const faces = new Uint32Array(bytes.buffer, 2 * positions.byteLength, header.faces * CORNERS);
  const channels = channelsOf(header, bytes, 2 * positions.byteLength + faces.byteLength, count);
  return { ...header, positions, normals, faces, channels };
}

function channelsOf(header, bytes, start, count) {
  const channels = {};
  for (const spec of header.channels) {
    const length = count * spec.width;
    channels[spec.name] = { ...spec, data: planesOf(bytes, start, spec, length) };
    start += spec.planes * length * spec.size;
  }
  return channels;
}

// An impact of the part as a replay ends: its own frames on the replay's surface.
export async function unpackImpact(header, packed, replay) {
  const { vertices, faces, colours, light } = replay, positions = new Float32Array(replay.positions.length);
  displaced(replay, replay.frames.length - 1, positions);
  return { ...header, vertices, faces, colours, light, positions, channels: channelsOf(header, await inflate(packed), 0, vertices) };
}

// Positions at a frame of a replay: each vertex moves along its own normal.
export function displaced({ positions, normals, channels }, frame, out) {
  const { low, step } = channels.displacement, raw = plane({ channels }, "displacement", frame);
  for (let i = 0; i < positions.length; i++) out[i] = positions[i] + normals[i] * (low + step * raw[(i / 3) | 0]);
}

// The raw plane of a field at a frame; value = low + step * raw.
export function plane(replay, name, frame) {
  const channel = replay.channels[name];
  return channel.data[channel.frames[frame]];
}
