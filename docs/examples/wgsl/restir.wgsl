// A backend in WGSL: one entry point a pass, one invocation a row, single precision.
//
// Written from the contract alone (docs/reference/contract.md).  Inputs lie one after the
// other in two buffers, so that any device has enough bindings; P says where.  P[1] plants
// one mistake that others have made, by its number in backend.py; 0 is none.

@group(0) @binding(0) var<storage, read> P: array<u32>;
@group(0) @binding(1) var<storage, read> F: array<f32>;
@group(0) @binding(2) var<storage, read> B: array<u32>;
@group(0) @binding(3) var<storage, read_write> OUT_F: array<f32>;
@group(0) @binding(4) var<storage, read_write> OUT_B: array<u32>;

const PI = 3.14159265358979;

const JACOBIAN_DIVIDED = 1u;
const JACOBIAN_OMITTED = 2u;
const JACOBIAN_UNSQUARED = 3u;
const JACOBIAN_RECEIVER_COSINE = 4u;
const JACOBIAN_CLAMPED = 5u;
const COSINE_OMITTED = 6u;
const COSINE_TWICE = 7u;
const MISSING_ONE_OVER_PI = 8u;
const ONE_OVER_M = 9u;
const NULLS_NOT_COUNTED = 10u;
const M_TIMES_TWO = 11u;
const CAP_MISSING = 12u;
const CONFIDENCE_MISSING = 13u;
const SOURCE_TARGET = 14u;
const CANONICAL_MISSING = 15u;
const VISIBILITY_IGNORED_IN_Z = 16u;
const VISIBILITY_IGNORED_IN_WEIGHT = 17u;
const HIDDEN_NOT_COUNTED = 18u;
const ACCEPT_OLD_SUM = 19u;
const WRONG_PDF = 20u;
const RANDOM_REUSED = 21u;
const DEPTH_RELATIVE_TO_OWN = 22u;
const RADIUS_NOT_HALVED = 23u;
const ALBEDO_MISSING = 24u;
const CAP_BEFORE_WEIGHT = 25u;

fn planted(number: u32) -> bool { return P[1] == number; }

// ---------------------------------------------------------------- settings and buffers

fn rows() -> u32 { return P[0]; }
fn count() -> u32 { return P[2]; }
fn outgoing() -> bool { return P[3] == 1u; }
fn by_domain() -> bool { return P[4] == 1u && !planted(ONE_OVER_M); }  // 1/Z, not 1/M
fn uniform_source() -> bool { return P[5] == 1u; }
fn image_width() -> i32 { return i32(P[6]); }
fn cap() -> f32 { return bitcast<f32>(P[7]); }
fn first_radius() -> f32 { return bitcast<f32>(P[8]); }
fn least_radius() -> f32 { return bitcast<f32>(P[9]); }
fn least_cosine() -> f32 { return bitcast<f32>(P[10]); }
fn most_depth() -> f32 { return bitcast<f32>(P[11]); }

// Input j of the pass at row i, and output j.
fn real(j: u32, i: u32) -> f32 { return F[P[16u + j] + i]; }
fn vec(j: u32, i: u32) -> vec3<f32> {
  let at = P[16u + j] + 3u * i;
  return vec3<f32>(F[at], F[at + 1u], F[at + 2u]);
}
fn word(j: u32, i: u32) -> u32 { return B[P[16u + j] + i]; }
fn put(j: u32, i: u32, value: f32) { OUT_F[P[40u + j] + i] = value; }
fn put_vec(j: u32, i: u32, value: vec3<f32>) {
  let at = P[40u + j] + 3u * i;
  OUT_F[at] = value.x;
  OUT_F[at + 1u] = value.y;
  OUT_F[at + 2u] = value.z;
}
fn put_word(j: u32, i: u32, value: u32) { OUT_B[P[40u + j] + i] = value; }

// ---------------------------------------------------------------- formulas

struct Receiver { position: vec3<f32>, normal: vec3<f32>, albedo: vec3<f32> }
struct Sample { position: vec3<f32>, normal: vec3<f32>, radiance: vec3<f32> }
struct Reservoir { y: Sample, W: f32, M: f32 }

fn quotient(a: f32, b: f32) -> f32 {
  if (b == 0.0) { return 0.0; }
  return a / b;
}

fn luminance(c: vec3<f32>) -> f32 { return dot(c, vec3<f32>(0.2126, 0.7152, 0.0722)); }

fn cosine_of(x: Receiver, v: vec3<f32>) -> f32 {
  // 0 where the square of the distance is too small for single precision.
  let cosine = quotient(dot(x.normal, v), sqrt(dot(v, v)));
  if (planted(COSINE_OMITTED)) { return 1.0; }
  if (planted(COSINE_TWICE)) { return cosine * cosine; }
  return cosine;
}

// p_hat of Equation 9 or 10; 0 below the horizon and on the unlit side.
fn target_of(x: Receiver, y: Sample) -> f32 {
  let v = y.position - x.position;
  if (dot(x.normal, v) <= 0.0 || dot(y.normal, v) >= 0.0) { return 0.0; }
  if (outgoing()) { return luminance(y.radiance); }
  let light = luminance(x.albedo * y.radiance) * cosine_of(x, v);
  if (planted(MISSING_ONE_OVER_PI)) { return light; }
  return light / PI;
}

// Equation 11.
fn jacobian_of(x_from: Receiver, x_to: Receiver, y: Sample) -> f32 {
  if (planted(JACOBIAN_OMITTED)) { return 1.0; }
  let v = x_from.position - y.position;
  let w = x_to.position - y.position;
  let d_from = dot(v, v);
  let d_to = dot(w, w);
  if (d_from == 0.0 || d_to == 0.0) { return 0.0; }
  var n_from = y.normal;
  var n_to = y.normal;
  if (planted(JACOBIAN_RECEIVER_COSINE)) { n_from = x_from.normal; n_to = x_to.normal; }
  let cosine_from = abs(dot(n_from, v)) / sqrt(d_from);
  let cosine_to = abs(dot(n_to, w)) / sqrt(d_to);
  if (cosine_from == 0.0) { return 0.0; }
  var ratio = d_from / d_to;
  if (planted(JACOBIAN_UNSQUARED)) { ratio = sqrt(ratio); }
  let J = cosine_to / cosine_from * ratio;
  if (planted(JACOBIAN_DIVIDED)) { return quotient(1.0, J); }
  if (planted(JACOBIAN_CLAMPED)) { return clamp(J, 1.0 / 3.0, 3.0); }
  return min(J, 3.4e38);
}

fn keeps(u: f32, before: f32, w: f32) -> bool {
  if (before == 0.0) { return w > 0.0; }
  if (planted(ACCEPT_OLD_SUM)) { return u * before < w; }
  return u * (before + w) < w;
}

fn alike(n_a: vec3<f32>, z_a: f32, n_b: vec3<f32>, z_b: f32) -> bool {
  var scale = max(z_a, z_b);
  if (planted(DEPTH_RELATIVE_TO_OWN)) { scale = z_a; }
  return z_a > 0.0 && z_b > 0.0 && dot(n_a, n_b) >= least_cosine()
    && abs(z_a - z_b) <= most_depth() * scale;
}

// ---------------------------------------------------------------- kernels

@compute @workgroup_size(64)
fn pass_random(@builtin(global_invocation_id) id: vec3<u32>) {
  let i = id.x;
  if (i >= rows()) { return; }
  var v = vec4<u32>(word(0u, 4u * i), word(0u, 4u * i + 1u), word(0u, 4u * i + 2u),
                    word(0u, 4u * i + 3u)) * 1664525u + 1013904223u;
  v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
  v ^= v >> vec4<u32>(16u);
  v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
  for (var k = 0u; k < 4u; k++) {
    put_word(0u, 4u * i + k, v[k]);
    put(1u, 4u * i + k, f32(v[k] >> 8u) * 0x1p-24f);
  }
}

@compute @workgroup_size(64)
fn pass_direction(@builtin(global_invocation_id) id: vec3<u32>) {
  let i = id.x;
  if (i >= rows()) { return; }
  let n = vec(0u, i);
  let u = vec2<f32>(real(1u, 2u * i), real(1u, 2u * i + 1u));
  // Any frame about n will do.
  var axis = vec3<f32>(0.0, 1.0, 0.0);
  if (abs(n.x) < 0.6) { axis = vec3<f32>(1.0, 0.0, 0.0); }
  let t = normalize(axis - dot(axis, n) * n);
  let b = cross(n, t);
  var cosine = sqrt(1.0 - u.x);
  var sine = sqrt(u.x);
  var pdf = cosine / PI;
  if (uniform_source()) {
    cosine = u.x;
    sine = sqrt((1.0 - cosine) * (1.0 + cosine));
    pdf = 1.0 / (2.0 * PI);
    if (planted(WRONG_PDF)) { pdf = 1.0 / PI; }
  }
  let phi = 2.0 * PI * u.y;
  put_vec(0u, i, sine * cos(phi) * t + sine * sin(phi) * b + cosine * n);
  put(1u, i, pdf);
}

fn receiver(j: u32, i: u32) -> Receiver {
  return Receiver(vec(j, i), vec(j + 1u, i), vec(j + 2u, i));
}
fn sample(j: u32, i: u32) -> Sample {
  return Sample(vec(j, i), vec(j + 1u, i), vec(j + 2u, i));
}
fn reservoir(j: u32, i: u32) -> Reservoir {
  return Reservoir(sample(j, i), real(j + 3u, i), real(j + 4u, i));
}

@compute @workgroup_size(64)
fn pass_target(@builtin(global_invocation_id) id: vec3<u32>) {
  let i = id.x;
  if (i >= rows()) { return; }
  put(0u, i, target_of(receiver(0u, i), sample(3u, i)));
}

@compute @workgroup_size(64)
fn pass_jacobian(@builtin(global_invocation_id) id: vec3<u32>) {
  let i = id.x;
  if (i >= rows()) { return; }
  let n = vec(3u, i);
  let y = Sample(vec(2u, i), n, n);
  put(0u, i, jacobian_of(Receiver(vec(0u, i), n, n), Receiver(vec(1u, i), n, n), y));
}

@compute @workgroup_size(64)
fn pass_merge(@builtin(global_invocation_id) id: vec3<u32>) {
  let i = id.x;
  if (i >= rows()) { return; }
  let w_a = real(0u, i);
  let w_b = real(2u, i);
  put_word(0u, i, select(0u, 1u, keeps(real(4u, i), w_a, w_b)));
  put(1u, i, w_a + w_b);
  put(2u, i, real(1u, i) + real(3u, i));
}

@compute @workgroup_size(64)
fn pass_finalize(@builtin(global_invocation_id) id: vec3<u32>) {
  let i = id.x;
  if (i >= rows()) { return; }
  put(0u, i, min(quotient(quotient(real(0u, i), real(1u, i)), real(2u, i)), 3.4e38));
}

@compute @workgroup_size(64)
fn pass_similar(@builtin(global_invocation_id) id: vec3<u32>) {
  let i = id.x;
  if (i >= rows()) { return; }
  let yes = alike(vec(0u, i), real(1u, i), vec(2u, i), real(3u, i));
  put_word(0u, i, select(0u, 1u, yes));
}

// ---------------------------------------------------------------- streams

// A competitor; elsewhere: it was made at x, from where `sees` says which samples are seen.
struct Entry {
  y: Sample, p_hat: f32, w: f32, M: f32, u: f32,
  elsewhere: bool, x: Receiver, sees: u32, place: u32,
}

fn confidence(w: f32) -> f32 {
  if (planted(NULLS_NOT_COUNTED) && !(w > 0.0)) { return 0.0; }
  return 1.0;
}

fn fresh(x: Receiver, y: Sample, pdf: f32, u: f32) -> Entry {
  let p_hat = target_of(x, y);
  let w = quotient(p_hat, pdf);
  return Entry(y, p_hat, w, confidence(w), u, false, x, 0u, 0u);
}

fn reused(x: Receiver, r: Reservoir, u: f32, place: u32) -> Entry {
  let p_hat = target_of(x, r.y);
  var M = r.M;
  if (planted(CONFIDENCE_MISSING)) { M = 1.0; }
  return Entry(r.y, p_hat, p_hat * r.W * M, r.M, u, false, x, 0u, place);
}

fn shifted(x: Receiver, x_from: Receiver, r: Reservoir, u: f32, place: u32, seen: bool,
           sees: u32) -> Entry {
  var e = reused(x, r, u, place);
  e.elsewhere = true;
  e.x = x_from;
  e.sees = sees;
  if (e.w > 0.0) { e.w = e.w * jacobian_of(x_from, x, r.y); }
  if (!seen && !planted(VISIBILITY_IGNORED_IN_WEIGHT)) { e.w = 0.0; }
  if (!seen && planted(HIDDEN_NOT_COUNTED)) { e.M = 0.0; }
  return e;
}

fn holds(e: Entry, y: Sample, place: u32) -> bool {
  let seen = ((e.sees >> place) & 1u) == 1u || planted(VISIBILITY_IGNORED_IN_Z);
  return seen && target_of(e.x, y) > 0.0;
}

// Outputs 0 to 4 are position, normal, radiance, W and M.
fn close(i: u32, kept: Entry, w: f32, M: f32, sum: f32) {
  var Z = sum;
  if (planted(CAP_BEFORE_WEIGHT)) { Z = min(Z, cap()); }
  var p_hat = kept.p_hat;
  if (planted(SOURCE_TARGET) && kept.elsewhere) { p_hat = target_of(kept.x, kept.y); }
  put_vec(0u, i, kept.y.position);
  put_vec(1u, i, kept.y.normal);
  put_vec(2u, i, kept.y.radiance);
  put(3u, i, quotient(quotient(w, p_hat), Z));
  if (planted(CAP_MISSING)) { put(4u, i, M); } else { put(4u, i, min(M, cap())); }
}

@compute @workgroup_size(64)
fn pass_initial(@builtin(global_invocation_id) id: vec3<u32>) {
  let i = id.x;
  if (i >= rows()) { return; }
  let p_hat = target_of(receiver(0u, i), sample(3u, i));
  let w = quotient(p_hat, real(6u, i));
  put(0u, i, p_hat);
  put(1u, i, quotient(w, p_hat));
  put(2u, i, confidence(w));
}

@compute @workgroup_size(64)
fn pass_temporal(@builtin(global_invocation_id) id: vec3<u32>) {
  let i = id.x;
  if (i >= rows()) { return; }
  let x = receiver(0u, i);
  let a = reused(x, reservoir(3u, i), 0.0, 1u);
  let b = fresh(x, sample(8u, i), real(11u, i), real(12u, i));
  var kept = a;
  if (keeps(b.u, a.w, b.w)) { kept = b; }
  close(i, kept, a.w + b.w, a.M + b.M, a.M + b.M);
}

@compute @workgroup_size(64)
fn pass_moved(@builtin(global_invocation_id) id: vec3<u32>) {
  let i = id.x;
  if (i >= rows()) { return; }
  let x = receiver(0u, i);
  let seen = ((word(15u, 2u * i) >> 1u) & 1u) == 1u;
  let a = shifted(x, receiver(3u, i), reservoir(6u, i), 0.0, 1u, seen,
                  word(15u, 2u * i + 1u));
  let b = fresh(x, sample(11u, i), real(14u, i), real(16u, i));
  var kept = a;
  if (keeps(b.u, a.w, b.w)) { kept = b; }
  let M = a.M + b.M;
  var Z = M;
  if (by_domain()) {
    Z = 0.0;
    if (!planted(CANONICAL_MISSING)) { Z += b.M; }
    if (holds(a, kept.y, kept.place)) { Z += a.M; }
  }
  close(i, kept, a.w + b.w, M, Z);
}

fn neighbor_entry(x: Receiver, i: u32, k: u32) -> Entry {
  let n = count();
  let row = bitcast<i32>(word(13u, i * n + k));
  if (row < 0) {
    var none = reused(x, reservoir(3u, i), 0.0, k + 1u);
    none.w = 0.0;
    none.M = 0.0;
    none.elsewhere = true;
    return none;
  }
  let at = u32(row);
  let seen = ((word(14u, i * (n + 1u)) >> (k + 1u)) & 1u) == 1u;
  var u = real(16u, i * n + k);
  if (planted(RANDOM_REUSED)) { u = real(16u, i * n); }
  var e = shifted(x, receiver(0u, at), reservoir(3u, at), u, k + 1u, seen,
                  word(14u, i * (n + 1u) + k + 1u));
  if (planted(M_TIMES_TWO)) { e.w = 2.0 * e.w; }
  return e;
}

@compute @workgroup_size(64)
fn pass_spatial(@builtin(global_invocation_id) id: vec3<u32>) {
  let i = id.x;
  if (i >= rows()) { return; }
  let x = receiver(0u, i);
  let past = reused(x, reservoir(8u, i), 0.0, count() + 1u);
  let own = reused(x, reservoir(3u, i), real(15u, i), 0u);
  var kept = past;
  var w = past.w;
  var M = past.M + own.M;
  if (keeps(own.u, w, own.w)) { kept = own; }
  w += own.w;
  for (var k = 0u; k < count(); k++) {
    let e = neighbor_entry(x, i, k);
    if (keeps(e.u, w, e.w)) { kept = e; }
    w += e.w;
    M += e.M;
  }
  var Z = M;
  if (by_domain()) {
    Z = past.M;
    if (!planted(CANONICAL_MISSING)) { Z += own.M; }
    for (var k = 0u; k < count(); k++) {
      let e = neighbor_entry(x, i, k);
      if (e.M > 0.0 && holds(e, kept.y, kept.place)) { Z += e.M; }
    }
  }
  close(i, kept, w, M, Z);
}

@compute @workgroup_size(64)
fn pass_neighbors(@builtin(global_invocation_id) id: vec3<u32>) {
  let i = id.x;
  if (i >= rows()) { return; }
  let width = image_width();
  let height = i32(rows()) / width;
  let x = i32(i) % width;
  let y = i32(i) / width;
  var radius = max(first_radius() * f32(width), least_radius());
  for (var k = 0u; k < count(); k++) {
    let at = (i * count() + k) * 2u;
    let r = radius * sqrt(real(2u, at));
    let phi = 2.0 * PI * real(2u, at + 1u);
    let x_to = x + i32(round(r * cos(phi)));
    let y_to = y + i32(round(r * sin(phi)));
    var row = i;
    var usable = x_to >= 0 && x_to < width && y_to >= 0 && y_to < height;
    if (usable) { row = u32(y_to * width + x_to); }
    usable = usable && alike(vec(0u, i), real(1u, i), vec(0u, row), real(1u, row));
    var found = 0xffffffffu;
    if (usable && row != i) { found = row; }
    put_word(0u, i * count() + k, found);
    if (!usable && !planted(RADIUS_NOT_HALVED)) { radius = max(radius / 2.0, least_radius()); }
  }
}

@compute @workgroup_size(64)
fn pass_shade(@builtin(global_invocation_id) id: vec3<u32>) {
  let i = id.x;
  if (i >= rows()) { return; }
  let x = receiver(0u, i);
  let y = sample(3u, i);
  let v = y.position - x.position;
  var color = vec3<f32>(0.0);
  if (dot(x.normal, v) > 0.0 && dot(y.normal, v) < 0.0) {
    var scale = real(6u, i) * cosine_of(x, v);
    if (!planted(MISSING_ONE_OVER_PI)) { scale = scale / PI; }
    color = x.albedo * y.radiance * scale;
    if (planted(ALBEDO_MISSING)) { color = y.radiance * scale; }
  }
  put_vec(0u, i, color);
}
