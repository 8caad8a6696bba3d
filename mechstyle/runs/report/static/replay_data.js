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
  let start = 2 * positions.byteLength + faces.byteLength;
  const channels = {};
  for (const spec of header.channels) {
    const length = count * spec.width;
    channels[spec.name] = { ...spec, data: planesOf(bytes, start, spec, length) };
    start += spec.planes * length * spec.size;
  }
  return { ...header, positions, normals, faces, channels };
}

// The raw plane of a field at a frame; value = low + step * raw.
export function plane(replay, name, frame) {
  const channel = replay.channels[name];
  return channel.data[channel.frames[frame]];
}
