// ReSTIR GI in CUDA: a kernel for each pass, one thread a row, in single precision.
//
//     nvcc -O2 -std=c++17 -shared -Xcompiler -fPIC -o restir.so restir.cu
//     g++ -O2 -std=c++17 -shared -fPIC -o restir.so -x c++ restir.cu
//
// The second runs it on the host (cuda_on_host.h); backend.py does one or the other.
// Written from the contract alone (docs/reference/contract.md), which names the buffers.

#include <float.h>
#include <math.h>

#ifdef __CUDACC__
#include <cuda_runtime.h>
#define LAUNCH(kernel, blocks, threads, params) kernel<<<blocks, threads>>>(params)
#else
#include "cuda_on_host.h"
#define LAUNCH(kernel, blocks, threads, params) run_grid(kernel, blocks, threads, params)
#endif

constexpr float PI = 3.14159265358979f;
constexpr int THREADS = 128;

// ---------------------------------------------------------------- buffers

// Structures of arrays on the device.  backend.py lists the same fields in this order.
struct Surfaces {
    const float3 *position, *normal, *albedo;
};

struct Samples {
    const float3 *position, *normal, *radiance;
};

struct Reservoirs {
    Samples y;
    const float *W, *M;
};

struct Inputs {
    Surfaces here, there;  // visible points, and those of the past
    Reservoirs own, past;
    Samples fresh;
    const float *pdf, *new_pdf, *u, *u_own, *u_neighbors, *depth;
    const int* neighbors;
    const unsigned* visible;
    const uint4* key;
    const float3 *x_from, *x_to;
    const float *w_a, *M_a, *w_b, *M_b;
    const float *w, *p_hat, *Z;
    const float3 *normal_a, *normal_b;
    const float *depth_a, *depth_b;
};

struct Outputs {
    float3 *position, *normal, *radiance;
    float *W, *M, *w, *p_hat, *pdf, *jacobian;
    float3 *direction, *color;
    uint4* words;
    float4* u;
    unsigned *second, *similar;
    int* neighbors;
};

struct Settings {
    int rows, count;  // N and K
    int outgoing, by_support, uniform;
    int width;
    float radius, min_radius, min_cosine, max_depth, cap;
};

struct Params {
    Settings set;
    Inputs in;
    Outputs out;
};

// ---------------------------------------------------------------- records of a thread

struct Surface {
    float3 position, normal, albedo;
};

struct Sample {
    float3 position, normal, radiance;
};

struct Reservoir {
    Sample y;
    float W, M;
};

__device__ Surface load(const Surfaces& a, int i) {
    return {a.position[i], a.normal[i], a.albedo[i]};
}

__device__ Sample load(const Samples& a, int i) {
    return {a.position[i], a.normal[i], a.radiance[i]};
}

__device__ Reservoir load(const Reservoirs& a, int i) {
    return {load(a.y, i), a.W[i], a.M[i]};
}

// ---------------------------------------------------------------- arithmetic

__device__ float3 operator+(float3 a, float3 b) {
    return make_float3(a.x + b.x, a.y + b.y, a.z + b.z);
}

__device__ float3 operator-(float3 a, float3 b) {
    return make_float3(a.x - b.x, a.y - b.y, a.z - b.z);
}

__device__ float3 operator*(float3 a, float3 b) {
    return make_float3(a.x * b.x, a.y * b.y, a.z * b.z);
}

__device__ float3 operator*(float3 a, float s) {
    return make_float3(a.x * s, a.y * s, a.z * s);
}

__device__ float dot(float3 a, float3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }

// Without squares that overflow or vanish.
__device__ float length(float3 a) { return norm3df(a.x, a.y, a.z); }

__device__ float limited(float a) { return fminf(a, FLT_MAX); }

// A quotient by 0 is 0, and none is infinite.
__device__ float quotient(float a, float b) { return b == 0.0f ? 0.0f : limited(a / b); }

__device__ float luminance(float3 c) {
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}

// ---------------------------------------------------------------- formulas

// cos θ at the visible point; 0 below its horizon, and where the sample shows its back.
__device__ float cosine_towards(const Surface& x, const Sample& y) {
    float3 v = y.position - x.position;
    float distance = length(v);
    float3 direction = v * quotient(1.0f, distance);
    if (dot(y.normal, direction) >= 0.0f) return 0.0f;
    return fmaxf(dot(x.normal, direction), 0.0f);
}

// p̂ of Equation 10 or 9.
__device__ float target_at(const Params& p, const Surface& x, const Sample& y) {
    float cosine = cosine_towards(x, y);
    if (p.set.outgoing) return cosine > 0.0f ? luminance(y.radiance) : 0.0f;
    return luminance(x.albedo * y.radiance) * (cosine / PI);
}

// Equation 11.
__device__ float jacobian_of(float3 from, float3 to, float3 position, float3 normal) {
    float3 v_from = from - position;
    float3 v_to = to - position;
    float distance_from = length(v_from);
    float distance_to = length(v_to);
    float cosine_from = fabsf(quotient(dot(normal, v_from), distance_from));
    float cosine_to = fabsf(quotient(dot(normal, v_to), distance_to));
    float distances = quotient(distance_from, distance_to);
    return limited(quotient(cosine_to, cosine_from) * distances * distances);
}

// Whether a candidate replaces what those before it have left.
__device__ bool replaces(float u, float w_before, float w) {
    if (w_before == 0.0f) return w > 0.0f;
    return u * (w_before + w) < w;
}

__device__ bool are_similar(const Settings& set, float3 n_a, float z_a, float3 n_b, float z_b) {
    if (z_a <= 0.0f || z_b <= 0.0f) return false;
    if (dot(n_a, n_b) < set.min_cosine) return false;
    return fabsf(z_a - z_b) <= set.max_depth * fmaxf(z_a, z_b);
}

// ---------------------------------------------------------------- candidate streams

struct Candidate {
    Sample y;
    float p_hat, w, M;
    int bit;  // that tells in `visible` who sees y
};

struct Stream {
    Candidate kept;
    float w, M;
};

__device__ void add(Stream& s, const Candidate& c, float u) {
    if (replaces(u, s.w, c.w)) s.kept = c;
    s.w += c.w;
    s.M += c.M;
}

__device__ Candidate drawn(const Params& p, const Surface& x, const Sample& y, float pdf) {
    float p_hat = target_at(p, x, y);
    float w = quotient(p_hat, pdf);
    return {y, p_hat, w, 1.0f, 0};
}

__device__ Candidate reused(const Params& p, const Surface& x, const Reservoir& r, int bit) {
    float p_hat = target_at(p, x, r.y);
    float w = limited(p_hat * r.W) * r.M;
    return {r.y, p_hat, limited(w), r.M, bit};
}

// A reservoir of another point; `sees` tells what x sees.
__device__ Candidate shifted(const Params& p, const Surface& x, const Surface& x_from,
                             const Reservoir& r, int bit, unsigned sees) {
    Candidate c = reused(p, x, r, bit);
    float jacobian = jacobian_of(x_from.position, x.position, r.y.position, r.y.normal);
    c.w = limited(c.w * jacobian);
    if (!(sees >> bit & 1u)) c.w = 0.0f;
    return c;
}

// Whether what is kept could have been made at another point, which `sees` so much.
__device__ bool supports(const Params& p, const Surface& x, const Candidate& kept, unsigned sees) {
    bool seen = sees >> kept.bit & 1u;
    return seen && target_at(p, x, kept.y) > 0.0f;
}

__device__ void store(const Params& p, int i, const Stream& s, float Z) {
    p.out.position[i] = s.kept.y.position;
    p.out.normal[i] = s.kept.y.normal;
    p.out.radiance[i] = s.kept.y.radiance;
    p.out.W[i] = quotient(quotient(s.w, s.kept.p_hat), Z);
    p.out.M[i] = fminf(s.M, p.set.cap);
}

// ---------------------------------------------------------------- kernels

__device__ int row_of_thread() { return blockIdx.x * blockDim.x + threadIdx.x; }

__device__ void mix(uint4& v) {
    v.x += v.y * v.w;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v.w += v.y * v.z;
}

__device__ float fraction(unsigned word) { return (word >> 8) * (1.0f / 16777216.0f); }

__global__ void random_kernel(Params p) {
    int i = row_of_thread();
    if (i >= p.set.rows) return;
    uint4 v = p.in.key[i];
    v.x = v.x * 1664525u + 1013904223u;
    v.y = v.y * 1664525u + 1013904223u;
    v.z = v.z * 1664525u + 1013904223u;
    v.w = v.w * 1664525u + 1013904223u;
    mix(v);
    v.x ^= v.x >> 16;
    v.y ^= v.y >> 16;
    v.z ^= v.z >> 16;
    v.w ^= v.w >> 16;
    mix(v);
    p.out.words[i] = v;
    p.out.u[i] = make_float4(fraction(v.x), fraction(v.y), fraction(v.z), fraction(v.w));
}

__global__ void direction_kernel(Params p) {
    int i = row_of_thread();
    if (i >= p.set.rows) return;
    float u = p.in.u[2 * i];
    float azimuth = 2.0f * PI * p.in.u[2 * i + 1];
    float cosine = p.set.uniform ? u : sqrtf(1.0f - u);
    float sine = p.set.uniform ? sqrtf((1.0f - u) * (1.0f + u)) : sqrtf(u);
    // Tangents without a branch that would split a warp.
    float3 n = p.in.here.normal[i];
    float sign = copysignf(1.0f, n.z);
    float a = -1.0f / (sign + n.z);
    float b = n.x * n.y * a;
    float3 tangent = make_float3(1.0f + sign * n.x * n.x * a, sign * b, -sign * n.x);
    float3 bitangent = make_float3(b, sign + n.y * n.y * a, -n.y);
    float3 across = tangent * cosf(azimuth) + bitangent * sinf(azimuth);
    p.out.direction[i] = across * sine + n * cosine;
    p.out.pdf[i] = p.set.uniform ? 1.0f / (2.0f * PI) : cosine / PI;
}

__global__ void target_kernel(Params p) {
    int i = row_of_thread();
    if (i >= p.set.rows) return;
    p.out.p_hat[i] = target_at(p, load(p.in.here, i), load(p.in.own.y, i));
}

__global__ void jacobian_kernel(Params p) {
    int i = row_of_thread();
    if (i >= p.set.rows) return;
    p.out.jacobian[i] = jacobian_of(p.in.x_from[i], p.in.x_to[i], p.in.own.y.position[i],
                                    p.in.own.y.normal[i]);
}

__global__ void merge_kernel(Params p) {
    int i = row_of_thread();
    if (i >= p.set.rows) return;
    p.out.second[i] = replaces(p.in.u[i], p.in.w_a[i], p.in.w_b[i]);
    p.out.w[i] = limited(p.in.w_a[i] + p.in.w_b[i]);
    p.out.M[i] = p.in.M_a[i] + p.in.M_b[i];
}

__global__ void finalize_kernel(Params p) {
    int i = row_of_thread();
    if (i >= p.set.rows) return;
    p.out.W[i] = quotient(quotient(p.in.w[i], p.in.p_hat[i]), p.in.Z[i]);
}

__global__ void similar_kernel(Params p) {
    int i = row_of_thread();
    if (i >= p.set.rows) return;
    p.out.similar[i] = are_similar(p.set, p.in.normal_a[i], p.in.depth_a[i],
                                   p.in.normal_b[i], p.in.depth_b[i]);
}

__global__ void initial_kernel(Params p) {
    int i = row_of_thread();
    if (i >= p.set.rows) return;
    Candidate c = drawn(p, load(p.in.here, i), load(p.in.own.y, i), p.in.pdf[i]);
    p.out.p_hat[i] = c.p_hat;
    p.out.W[i] = quotient(c.w, c.p_hat);
    p.out.M[i] = c.M;
}

__global__ void temporal_kernel(Params p) {
    int i = row_of_thread();
    if (i >= p.set.rows) return;
    Surface x = load(p.in.here, i);
    Stream s = {};
    add(s, reused(p, x, load(p.in.past, i), 1), 0.0f);
    add(s, drawn(p, x, load(p.in.fresh, i), p.in.new_pdf[i]), p.in.u[i]);
    store(p, i, s, s.M);
}

__global__ void moved_kernel(Params p) {
    int i = row_of_thread();
    if (i >= p.set.rows) return;
    Surface x = load(p.in.here, i);
    Surface x_past = load(p.in.there, i);
    unsigned sees = p.in.visible[2 * i];
    unsigned past_sees = p.in.visible[2 * i + 1];
    Candidate past = shifted(p, x, x_past, load(p.in.past, i), 1, sees);
    Candidate fresh = drawn(p, x, load(p.in.fresh, i), p.in.new_pdf[i]);
    Stream s = {};
    add(s, past, 0.0f);
    add(s, fresh, p.in.u[i]);
    bool all = !p.set.by_support || supports(p, x_past, s.kept, past_sees);
    store(p, i, s, all ? s.M : fresh.M);
}

__global__ void neighbors_kernel(Params p) {
    int i = row_of_thread();
    if (i >= p.set.rows) return;
    const Settings& set = p.set;
    int height = set.rows / set.width;
    float radius = fmaxf(set.radius * set.width, set.min_radius);
    for (int k = i * set.count; k < (i + 1) * set.count; k++) {
        float r = radius * sqrtf(p.in.u[2 * k]);
        float azimuth = 2.0f * PI * p.in.u[2 * k + 1];
        int column = i % set.width + static_cast<int>(rintf(r * cosf(azimuth)));
        int line = i / set.width + static_cast<int>(rintf(r * sinf(azimuth)));
        bool inside = column >= 0 && column < set.width && line >= 0 && line < height;
        int j = inside ? line * set.width + column : i;
        bool usable = inside && are_similar(set, p.in.here.normal[i], p.in.depth[i],
                                            p.in.here.normal[j], p.in.depth[j]);
        p.out.neighbors[k] = usable && j != i ? j : -1;
        if (!usable) radius = fmaxf(0.5f * radius, set.min_radius);
    }
}

__global__ void spatial_kernel(Params p) {
    int i = row_of_thread();
    if (i >= p.set.rows) return;
    int count = p.set.count;
    const int* neighbors = p.in.neighbors + i * count;
    const unsigned* sees = p.in.visible + i * (count + 1);
    const float* u = p.in.u_neighbors + i * count;
    Surface x = load(p.in.here, i);
    Stream s = {};
    add(s, reused(p, x, load(p.in.past, i), count + 1), 0.0f);
    add(s, reused(p, x, load(p.in.own, i), 0), p.in.u_own[i]);
    float Z = s.M;
    for (int k = 0; k < count; k++) {
        int j = neighbors[k];
        if (j < 0) continue;
        add(s, shifted(p, x, load(p.in.here, j), load(p.in.own, j), k + 1, sees[0]), u[k]);
    }
    for (int k = 0; k < count; k++) {
        int j = neighbors[k];
        if (j < 0) continue;
        bool counts = !p.set.by_support || supports(p, load(p.in.here, j), s.kept, sees[k + 1]);
        if (counts) Z += p.in.own.M[j];
    }
    store(p, i, s, Z);
}

__global__ void shade_kernel(Params p) {
    int i = row_of_thread();
    if (i >= p.set.rows) return;
    Surface x = load(p.in.here, i);
    Sample y = load(p.in.own.y, i);
    float3 f = x.albedo * y.radiance * (cosine_towards(x, y) / PI);
    p.out.color[i] = f * p.in.own.W[i];
}

// ---------------------------------------------------------------- for backend.py

// Each gives what went wrong, or null.
static const char* told(cudaError_t error) {
    return error == cudaSuccess ? nullptr : cudaGetErrorString(error);
}

#define LAUNCHER(pass)                                                             \
    extern "C" const char* launch_##pass(const Params* p) {                        \
        LAUNCH(pass##_kernel, (p->set.rows + THREADS - 1) / THREADS, THREADS, *p); \
        cudaError_t error = cudaGetLastError();                                    \
        return told(error == cudaSuccess ? cudaDeviceSynchronize() : error);       \
    }

LAUNCHER(random)
LAUNCHER(direction)
LAUNCHER(target)
LAUNCHER(jacobian)
LAUNCHER(merge)
LAUNCHER(finalize)
LAUNCHER(similar)
LAUNCHER(initial)
LAUNCHER(temporal)
LAUNCHER(moved)
LAUNCHER(neighbors)
LAUNCHER(spatial)
LAUNCHER(shade)

extern "C" const char* device_allocate(void** device, size_t bytes) {
    return told(cudaMalloc(device, bytes));
}

extern "C" const char* device_free(void* device) { return told(cudaFree(device)); }

extern "C" const char* to_device(void* device, const void* host, size_t bytes) {
    return told(cudaMemcpy(device, host, bytes, cudaMemcpyHostToDevice));
}

extern "C" const char* to_host(void* host, const void* device, size_t bytes) {
    return told(cudaMemcpy(host, device, bytes, cudaMemcpyDeviceToHost));
}
