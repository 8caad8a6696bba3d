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

// Angles of the faces at their corners, by which vertex normals are weighted; those of the base surface serve every frame.
function anglesOf(p, faces) {
  return Float32Array.from(faces, (a, i) => {
    const first = i - (i % CORNERS), b = 3 * faces[first + ((i + 1) % CORNERS)], c = 3 * faces[first + ((i + 2) % CORNERS)];
    a *= 3;
    const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2], vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
    return Math.atan2(Math.hypot(uy * vz - uz * vy, uz * vx - ux * vz, ux * vy - uy * vx), ux * vx + uy * vy + uz * vz);
  });
}

// The vertices of a frame, as a replay or its impact moves them, and their own unit normals.
export function pose(replay, frame, positions, normals) {
  const { positions: base, faces } = replay;
  (replay.shape ?? displaced)(replay, frame, positions);
  const angles = (replay.angles ??= anglesOf(base, faces)), p = positions, n = normals;
  n.fill(0);
  for (let i = 0; i < faces.length; i += CORNERS) {
    const a = 3 * faces[i], b = 3 * faces[i + 1], c = 3 * faces[i + 2];
    const ux = p[b] - p[a], uy = p[b + 1] - p[a + 1], uz = p[b + 2] - p[a + 2], vx = p[c] - p[a], vy = p[c + 1] - p[a + 1], vz = p[c + 2] - p[a + 2];
    const x = uy * vz - uz * vy, y = uz * vx - ux * vz, z = ux * vy - uy * vx, length = Math.sqrt(x * x + y * y + z * z) || 1;
    const wa = angles[i] / length, wb = angles[i + 1] / length, wc = angles[i + 2] / length;
    n[a] += wa * x; n[a + 1] += wa * y; n[a + 2] += wa * z;
    n[b] += wb * x; n[b + 1] += wb * y; n[b + 2] += wb * z;
    n[c] += wc * x; n[c + 1] += wc * y; n[c + 2] += wc * z;
  }
  for (let i = 0; i < n.length; i += 3) {
    const length = Math.sqrt(n[i] * n[i] + n[i + 1] * n[i + 1] + n[i + 2] * n[i + 2]) || 1;
    n[i] /= length; n[i + 1] /= length; n[i + 2] /= length;
  }
}
