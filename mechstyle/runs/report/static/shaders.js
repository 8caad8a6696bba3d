// Light and colour of a part. Colours are display RGB; they are lit as linear light and turned back, as in the figures,
// by their lamps: the header has directions, in axes of the camera (right, up, towards the viewer), and intensities.

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
uniform vec3 key; uniform vec3 fill; uniform float keyLight; uniform float fillLight; uniform float sky; uniform float ground;
uniform float flatness; // share of the light on a field that does not depend on the shape
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

float light(vec3 n) {
  vec3 turned = vec3(1.0, upwards.z < 0.0 ? -1.0 : 1.0, 1.0); // what faces down is lit from below
  float lamps = keyLight * max(dot(n, normalize(key) * turned), 0.0) + fillLight * max(dot(n, normalize(fill) * turned), 0.0);
  return lamps + mix(ground, sky, 0.5 + 0.5 * dot(n, upwards));
}

void main() {
  vec3 facet = normalize(cross(dFdx(place), dFdy(place)));
  vec3 n = normalize(facing);
  n = normalize(mix(facet, n, smoothstep(0.70, 0.85, dot(facet, n)))); // edges stay crisp, rounds smooth
  float shade = styled ? light(n) : mix(light(n), 1.0, flatness);
  result = vec4(toDisplay(toLight(styled ? paint : mapped()) * shade), 1.0);
}`;
