// SPDX-License-Identifier: GPL-3.0-or-later
// Ambient occlusion of one object from its field: see ao_fields.md. GLSL 3.30.
//
// The three images are the OpenEXR files as they are, first row at v = 0, as 32-bit float 2D textures: linear filter,
// clamped, no mipmaps. Texels lie on the faces' edges, so no lookup leaves its face.

uniform sampler2D occlusion_map;  // a, b, c, r0
uniform sampler2D direction_map;  // C0, a'
uniform sampler2D moment_map;     // b', c', d, e
uniform vec3 centre;              // the JSON file's
uniform float r_near;
uniform float r_far;
uniform float A0;
uniform float p;
uniform float resolution;

const float PI = 3.14159265358979;

// Where direction w lies in an image of OpenEXR's cube layout.
vec2 cube_uv(vec3 w)
{
    vec3 size = abs(w);
    float is_x = step(size.y, size.x) * step(size.z, size.x);
    float is_y = (1.0 - is_x) * step(size.z, size.y);
    float is_z = 1.0 - is_x - is_y;
    float largest = is_x * w.x + is_y * w.y + is_z * w.z;
    float side = sign(largest);
    vec3 q = w / max(abs(largest), 1e-20);
    float right = is_x * side * q.z + is_y * q.x - is_z * side * q.x;
    float down = -is_x * q.y - is_y * side * q.z - is_z * q.y;
    float face = 2.0 * is_y + 4.0 * is_z + 0.5 - 0.5 * side;
    vec2 texel = 0.5 * (resolution - 1.0) * (vec2(right, down) + 1.0) + 0.5;
    return vec2(texel.x, face * resolution + texel.y) / vec2(resolution, 6.0 * resolution);
}

// What a cap of solid angle Omega blocks of the cosine-weighted sky; k is the cosine between its axis and the normal.
float cap_occlusion(float Omega, float k)
{
    float c = 1.0 - Omega / (2.0 * PI);
    float D = sqrt(max(1.0 - c * c - k * k, 1e-9));
    float A = ((1.0 - c * c) * k * atan(D, -c * k) + atan(D, c) - c * D) / PI;
    return clamp(A, 0.0, 1.0);
}

// The occlusion of the object at x for the unit normal n, both in the object's space. Multiply light from the sky by
// 1 - A; of several objects, by each one's 1 - A.
float ao_field(vec3 x, vec3 n)
{
    vec3 from_centre = x - centre;
    float r = max(length(from_centre), 1e-20);
    vec3 w = from_centre / r;
    vec2 uv = cube_uv(w);
    vec4 abc = textureLod(occlusion_map, uv, 0.0);
    vec4 towards = textureLod(direction_map, uv, 0.0);
    vec4 moment = textureLod(moment_map, uv, 0.0);
    float r_clamp = max(r, abc.w);
    float root = moment.z * r_clamp * sqrt(r_clamp * r_clamp - abc.w * abc.w);
    float Omega = 1.0 / ((abc.x * r_clamp + abc.y) * r_clamp + abc.z + root);
    float Omega_M = 1.0 / ((towards.w * r_clamp + moment.x) * r_clamp + moment.y + root);
    float M = Omega_M / (2.0 * PI) * (2.0 - Omega_M / (2.0 * PI));
    float larger = max(4.0 * PI * (1.0 - PI * M / Omega), Omega);
    vec3 Upsilon = normalize(pow(abc.w / r_clamp, moment.w) * towards.xyz - abc.w * w);
    float A = Omega / larger * cap_occlusion(min(larger, 4.0 * PI), dot(n, Upsilon));
    float t = pow(min(r / abc.w, 1.0), p);
    float blended = t * A + (1.0 - t) * A0;
    return blended * (1.0 - smoothstep(r_near, r_far, r));
}
