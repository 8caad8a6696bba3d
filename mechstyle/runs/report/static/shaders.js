// Light and colour of a part. Colours are display RGB; they are lit as linear light and turned back, as in the figures.

export const VERTEX = `#version 300 es
in vec3 position; in vec3 normal; in vec3 colour; in float raw;
uniform mat4 view; uniform mat4 projection; uniform float low; uniform float stride;
out vec3 place; out vec3 facing; out vec3 paint; out float value; out float unknown;
void main() {
  vec4 seen = view * vec4(position, 1.0);
  place = seen.xyz; facing = mat3(view) * normal; paint = colour;
  unknown = raw > 65534.0 ? 1.0 : 0.0; value = low + stride * raw;
  gl_Position = projection * seen;
}`;

export const FRAGMENT = `#version 300 es
precision highp float;
in vec3 place; in vec3 facing; in vec3 paint; in float value; in float unknown;
uniform sampler2D ramp; uniform bool styled; uniform bool split; uniform vec3 range; // low, top of the ramp, threshold
uniform vec3 above; uniform vec3 stripe; uniform vec3 line; uniform vec3 missing; uniform vec3 upwards; uniform float pixel;
out vec4 result;

vec3 toLight(vec3 c) { return mix(c / 12.92, pow((c + 0.055) / 1.055, vec3(2.4)), step(0.04045, c)); }
vec3 toDisplay(vec3 c) { c = clamp(c, 0.0, 1.0); return mix(c * 12.92, 1.055 * pow(c, vec3(1.0 / 2.4)) - 0.055, step(0.0031308, c)); }

// Values above the threshold are hatched and outlined, so that they are not told by colour alone.
vec3 mapped() {
  if (unknown > 0.0) return missing;
  vec3 shade = texture(ramp, vec2((clamp((value - range.x) / (range.y - range.x), 0.0, 1.0) * 255.0 + 0.5) / 256.0, 0.5)).rgb;
  if (!split) return shade;
  if (abs(value - range.z) < 1.1 * pixel * fwidth(value)) return line;
  bool hatched = mod(gl_FragCoord.x + gl_FragCoord.y, 9.0 * pixel) < 3.0 * pixel;
  return value > range.z ? (hatched ? stripe : above) : shade;
}

void main() {
  vec3 facet = normalize(cross(dFdx(place), dFdy(place)));
  vec3 n = normalize(facing);
  n = normalize(mix(facet, n, smoothstep(0.70, 0.85, dot(facet, n)))); // edges stay crisp, rounds smooth
  float lamps = 0.72 * max(dot(n, normalize(vec3(-0.55, 0.65, 0.52))), 0.0) + 0.22 * max(dot(n, normalize(vec3(0.85, 0.05, 0.52))), 0.0);
  float sky = mix(0.12, 0.26, 0.5 + 0.5 * dot(n, upwards));
  result = vec4(toDisplay(toLight(styled ? paint : mapped()) * (lamps + sky)), 1.0);
}`;
