// Surfaces in one colour, lit by the normals of their facets on the screen.
import {Color, GLSL3, RawShaderMaterial} from 'three';

/** As CSS would show it. */
export const plain = (style: string) => new Color().setStyle(style, '');

/** Begins a fragment shader that has `in vec3 seen`, the place as the camera sees it. */
export const kLight = `
precision highp float;
precision highp int;
in vec3 seen;
out vec4 drawn;
float light() {
  vec3 n = normalize(cross(dFdx(seen), dFdy(seen)));
  return 0.6 + 0.4 * abs(dot(n, normalize(vec3(0.2, 0.3, 0.9))));
}`;

export function shaded(style: string, opacity = 1): RawShaderMaterial {
  return new RawShaderMaterial({
    glslVersion: GLSL3, side: 2, transparent: opacity < 1, depthWrite: opacity === 1,
    vertexShader: `
in vec3 position;
uniform mat4 modelViewMatrix, projectionMatrix;
out vec3 seen;
void main() {
  vec4 at = modelViewMatrix * vec4(position, 1.0);
  seen = at.xyz;
  gl_Position = projectionMatrix * at;
}`,
    fragmentShader: kLight + `
uniform vec3 colour;
uniform float opacity;
void main() { drawn = vec4(colour * light(), opacity); }`,
    uniforms: {colour: {value: plain(style)}, opacity: {value: opacity}},
  });
}
