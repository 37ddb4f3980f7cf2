// A backend in HLSL: one entry point a pass, one thread a row, single precision.
//
// Written from the contract alone (docs/reference/contract.md), in what Slang and HLSL
// have in common: backend.py lets Slang compile it.  A reservoir is a stream that takes
// candidates one by one, as in RTXDI.  Inputs lie one after the other in two buffers, and
// Parameters says where.  Parameters[1] plants one mistake that others have made, by its
// number in backend.py; 0 is none.

[[vk::binding(0, 0)]] StructuredBuffer<uint> Parameters : register(t0);
[[vk::binding(1, 0)]] StructuredBuffer<float> Reals : register(t1);
[[vk::binding(2, 0)]] StructuredBuffer<uint> Words : register(t2);
[[vk::binding(3, 0)]] RWStructuredBuffer<float> RealsOut : register(u0);
[[vk::binding(4, 0)]] RWStructuredBuffer<uint> WordsOut : register(u1);

static const float PI = 3.14159265358979;
static const float LARGEST = 3.4e38;

static const uint JACOBIAN_DIVIDED = 1;
static const uint JACOBIAN_OMITTED = 2;
static const uint JACOBIAN_UNSQUARED = 3;
static const uint JACOBIAN_RECEIVER_COSINE = 4;
static const uint JACOBIAN_CLAMPED = 5;
static const uint COSINE_OMITTED = 6;
static const uint COSINE_TWICE = 7;
static const uint MISSING_ONE_OVER_PI = 8;
static const uint ONE_OVER_M = 9;
static const uint NULLS_NOT_COUNTED = 10;
static const uint M_TIMES_TWO = 11;
static const uint CAP_MISSING = 12;
static const uint CONFIDENCE_MISSING = 13;
static const uint SOURCE_TARGET = 14;
static const uint CANONICAL_MISSING = 15;
static const uint VISIBILITY_IGNORED_IN_Z = 16;
static const uint VISIBILITY_IGNORED_IN_WEIGHT = 17;
static const uint HIDDEN_NOT_COUNTED = 18;
static const uint ACCEPT_OLD_SUM = 19;
static const uint WRONG_PDF = 20;
static const uint RANDOM_REUSED = 21;
static const uint DEPTH_RELATIVE_TO_OWN = 22;
static const uint RADIUS_NOT_HALVED = 23;
static const uint ALBEDO_MISSING = 24;
static const uint CAP_BEFORE_WEIGHT = 25;

bool Planted(uint number) { return Parameters[1] == number; }

// ---------------------------------------------------------------- settings and buffers

uint RowCount() { return Parameters[0]; }
uint NeighborCount() { return Parameters[2]; }
bool TargetIsOutgoing() { return Parameters[3] == 1; }
bool WeightsBySources() { return Parameters[4] == 1 && !Planted(ONE_OVER_M); }  // 1/Z
bool SourceIsUniform() { return Parameters[5] == 1; }
int ImageWidth() { return int(Parameters[6]); }
float Cap() { return asfloat(Parameters[7]); }
float FirstRadius() { return asfloat(Parameters[8]); }
float LeastRadius() { return asfloat(Parameters[9]); }
float LeastCosine() { return asfloat(Parameters[10]); }
float LargestDepthDifference() { return asfloat(Parameters[11]); }

// Where input j begins, and output j.
uint In(uint j) { return Parameters[16 + j]; }
uint Out(uint j) { return Parameters[40 + j]; }

float Real(uint j, uint i) { return Reals[In(j) + i]; }
uint Word(uint j, uint i) { return Words[In(j) + i]; }

float3 Vector(uint j, uint i)
{
    uint at = In(j) + 3 * i;
    return float3(Reals[at], Reals[at + 1], Reals[at + 2]);
}

void StoreReal(uint j, uint i, float value) { RealsOut[Out(j) + i] = value; }
void StoreWord(uint j, uint i, uint value) { WordsOut[Out(j) + i] = value; }

void StoreVector(uint j, uint i, float3 value)
{
    uint at = Out(j) + 3 * i;
    RealsOut[at] = value.x;
    RealsOut[at + 1] = value.y;
    RealsOut[at + 2] = value.z;
}

struct Surface  // the visible point of a pixel
{
    float3 position;
    float3 normal;
    float3 albedo;
};

struct Sample
{
    float3 position;
    float3 normal;
    float3 radiance;
};

struct StoredReservoir
{
    Sample s;
    float W;
    float M;
};

Surface LoadSurface(uint j, uint i)
{
    Surface surface = { Vector(j, i), Vector(j + 1, i), Vector(j + 2, i) };
    return surface;
}

Sample LoadSample(uint j, uint i)
{
    Sample s = { Vector(j, i), Vector(j + 1, i), Vector(j + 2, i) };
    return s;
}

StoredReservoir LoadReservoir(uint j, uint i)
{
    StoredReservoir stored = { LoadSample(j, i), Real(j + 3, i), Real(j + 4, i) };
    return stored;
}

// ---------------------------------------------------------------- target and shift

float Luminance(float3 color) { return dot(color, float3(0.2126, 0.7152, 0.0722)); }

// A quotient by 0 is 0.
float Ratio(float numerator, float denominator)
{
    if (denominator == 0)
        return 0;
    return numerator / denominator;
}

bool IsLitFromFront(Surface x, Sample s)
{
    float3 v = s.position - x.position;
    return dot(x.normal, v) > 0 && dot(s.normal, v) < 0;
}

float CosineAt(Surface x, Sample s)
{
    float3 v = s.position - x.position;
    float cosine = Ratio(dot(x.normal, v), sqrt(dot(v, v)));
    if (Planted(COSINE_OMITTED))
        return 1;
    return Planted(COSINE_TWICE) ? cosine * cosine : cosine;
}

// Equation 9 or 10.
float TargetPdf(Surface x, Sample s)
{
    if (!IsLitFromFront(x, s))
        return 0;
    if (TargetIsOutgoing())
        return Luminance(s.radiance);
    float reflected = Luminance(x.albedo * s.radiance) * CosineAt(x, s);
    return Planted(MISSING_ONE_OVER_PI) ? reflected : reflected / PI;
}

// Equation 11: from the solid angle at one surface to that at the other.
float Jacobian(float3 from, float3 to, float3 position, float3 normal_from, float3 normal_to)
{
    if (Planted(JACOBIAN_OMITTED))
        return 1;
    float3 v = from - position;
    float3 w = to - position;
    float square_from = dot(v, v);
    float square_to = dot(w, w);
    if (square_from == 0 || square_to == 0)
        return 0;
    float cosine_from = abs(dot(normal_from, v)) / sqrt(square_from);
    float cosine_to = abs(dot(normal_to, w)) / sqrt(square_to);
    if (cosine_from == 0)
        return 0;
    float squares = square_from / square_to;
    if (Planted(JACOBIAN_UNSQUARED))
        squares = sqrt(squares);
    float J = cosine_to / cosine_from * squares;
    if (Planted(JACOBIAN_DIVIDED))
        return Ratio(1, J);
    if (Planted(JACOBIAN_CLAMPED))
        return clamp(J, 1.0 / 3.0, 3.0);
    return min(J, LARGEST);
}

float JacobianOf(Surface from, Surface to, Sample s)
{
    if (Planted(JACOBIAN_RECEIVER_COSINE))
        return Jacobian(from.position, to.position, s.position, from.normal, to.normal);
    return Jacobian(from.position, to.position, s.position, s.normal, s.normal);
}

bool AreSimilar(float3 normal_a, float depth_a, float3 normal_b, float depth_b)
{
    float scale = Planted(DEPTH_RELATIVE_TO_OWN) ? depth_a : max(depth_a, depth_b);
    return depth_a > 0 && depth_b > 0 && dot(normal_a, normal_b) >= LeastCosine()
        && abs(depth_a - depth_b) <= LargestDepthDifference() * scale;
}

// ---------------------------------------------------------------- the stream

struct Reservoir
{
    Sample s;
    float target_pdf;
    float weight_sum;
    float M;
    int source;  // of the kept sample: a bit of the masks of visibility, or -1 before any
};

Reservoir EmptyReservoir()
{
    Sample none = { float3(0, 0, 0), float3(0, 0, 0), float3(0, 0, 0) };
    Reservoir r = { none, 0, 0, 0, -1 };
    return r;
}

bool Keeps(float random, float sum_before, float weight)
{
    if (sum_before == 0)
        return weight > 0;
    float sum = Planted(ACCEPT_OLD_SUM) ? sum_before : sum_before + weight;
    return random * sum < weight;
}

void Stream(inout Reservoir r, Sample s, float target_pdf, float weight, float M, float random,
            int source)
{
    // The first candidate stands in the row even where its weight is 0.
    if (r.source < 0 || Keeps(random, r.weight_sum, weight))
    {
        r.s = s;
        r.target_pdf = target_pdf;
        r.source = source;
    }
    r.weight_sum += weight;
    r.M += M;
}

float Confidence(float weight)
{
    return Planted(NULLS_NOT_COUNTED) && !(weight > 0) ? 0.0 : 1.0;
}

void StreamNew(inout Reservoir r, Surface x, Sample s, float pdf, float random, int source)
{
    float target_pdf = TargetPdf(x, s);
    float weight = Ratio(target_pdf, pdf);
    Stream(r, s, target_pdf, weight, Confidence(weight), random, source);
}

// What this very surface has kept before: nothing is shifted.
void StreamOwn(inout Reservoir r, Surface x, StoredReservoir own, float random, int source)
{
    float target_pdf = TargetPdf(x, own.s);
    float M = Planted(CONFIDENCE_MISSING) ? 1.0 : own.M;
    Stream(r, own.s, target_pdf, target_pdf * own.W * M, own.M, random, source);
}

// What the surface at `from` has kept; `seen` is whether this surface sees its sample.
void StreamShifted(inout Reservoir r, Surface x, Surface from, StoredReservoir other, bool seen,
                   float random, int source)
{
    float target_pdf = TargetPdf(x, other.s);
    float M = Planted(CONFIDENCE_MISSING) ? 1.0 : other.M;
    float weight = target_pdf * other.W * M;
    if (weight > 0)
        weight *= JacobianOf(from, x, other.s);
    if (!seen && !Planted(VISIBILITY_IGNORED_IN_WEIGHT))
        weight = 0;
    bool is_counted = seen || !Planted(HIDDEN_NOT_COUNTED);
    if (Planted(SOURCE_TARGET))
        target_pdf = TargetPdf(from, other.s);
    Stream(r, other.s, target_pdf, weight, is_counted ? other.M : 0.0, random, source);
}

// Whether the surface at `from` could have made the kept sample: Z counts those that could.
bool CouldHaveMade(Reservoir r, Surface from, uint sees)
{
    bool seen = ((sees >> r.source) & 1) == 1 || Planted(VISIBILITY_IGNORED_IN_Z);
    return seen && TargetPdf(from, r.s) > 0;
}

// Outputs 0 to 4 are position, normal, radiance, W and M.
void StoreReservoir(uint i, Reservoir r, float Z)
{
    if (Planted(CAP_BEFORE_WEIGHT))
        Z = min(Z, Cap());
    StoreVector(0, i, r.s.position);
    StoreVector(1, i, r.s.normal);
    StoreVector(2, i, r.s.radiance);
    StoreReal(3, i, Ratio(Ratio(r.weight_sum, r.target_pdf), Z));
    StoreReal(4, i, Planted(CAP_MISSING) ? r.M : min(r.M, Cap()));
}

// ---------------------------------------------------------------- entry points: kernels

[shader("compute")] [numthreads(64, 1, 1)]
void pass_random(uint3 thread : SV_DispatchThreadID)
{
    uint i = thread.x;
    if (i >= RowCount())
        return;
    uint4 v = uint4(Word(0, 4 * i), Word(0, 4 * i + 1), Word(0, 4 * i + 2), Word(0, 4 * i + 3));
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    v ^= v >> 16;
    v.x += v.y * v.w; v.y += v.z * v.x; v.z += v.x * v.y; v.w += v.y * v.z;
    for (uint lane = 0; lane < 4; lane++)
    {
        StoreWord(0, 4 * i + lane, v[lane]);
        StoreReal(1, 4 * i + lane, float(v[lane] >> 8) / 16777216.0);
    }
}

[shader("compute")] [numthreads(64, 1, 1)]
void pass_direction(uint3 thread : SV_DispatchThreadID)
{
    uint i = thread.x;
    if (i >= RowCount())
        return;
    float3 n = Vector(0, i);
    float u = Real(1, 2 * i);
    float phi = 2 * PI * Real(1, 2 * i + 1);
    float3 axis = abs(n.x) < 0.6 ? float3(1, 0, 0) : float3(0, 1, 0);
    float3 tangent = normalize(axis - dot(axis, n) * n);
    float3 bitangent = cross(n, tangent);
    float cosine = SourceIsUniform() ? u : sqrt(1 - u);
    float sine = SourceIsUniform() ? sqrt((1 - u) * (1 + u)) : sqrt(u);
    float pdf = cosine / PI;
    if (SourceIsUniform())
        pdf = Planted(WRONG_PDF) ? 1 / PI : 1 / (2 * PI);
    StoreVector(0, i, sine * cos(phi) * tangent + sine * sin(phi) * bitangent + cosine * n);
    StoreReal(1, i, pdf);
}

[shader("compute")] [numthreads(64, 1, 1)]
void pass_target(uint3 thread : SV_DispatchThreadID)
{
    uint i = thread.x;
    if (i >= RowCount())
        return;
    StoreReal(0, i, TargetPdf(LoadSurface(0, i), LoadSample(3, i)));
}

[shader("compute")] [numthreads(64, 1, 1)]
void pass_jacobian(uint3 thread : SV_DispatchThreadID)
{
    uint i = thread.x;
    if (i >= RowCount())
        return;
    float3 normal = Vector(3, i);
    StoreReal(0, i, Jacobian(Vector(0, i), Vector(1, i), Vector(2, i), normal, normal));
}

[shader("compute")] [numthreads(64, 1, 1)]
void pass_merge(uint3 thread : SV_DispatchThreadID)
{
    uint i = thread.x;
    if (i >= RowCount())
        return;
    float first = Real(0, i);
    float second = Real(2, i);
    StoreWord(0, i, Keeps(Real(4, i), first, second) ? 1 : 0);
    StoreReal(1, i, first + second);
    StoreReal(2, i, Real(1, i) + Real(3, i));
}

[shader("compute")] [numthreads(64, 1, 1)]
void pass_finalize(uint3 thread : SV_DispatchThreadID)
{
    uint i = thread.x;
    if (i >= RowCount())
        return;
    float W = Ratio(Ratio(Real(0, i), Real(1, i)), Real(2, i));
    StoreReal(0, i, min(W, LARGEST));
}

[shader("compute")] [numthreads(64, 1, 1)]
void pass_similar(uint3 thread : SV_DispatchThreadID)
{
    uint i = thread.x;
    if (i >= RowCount())
        return;
    bool similar = AreSimilar(Vector(0, i), Real(1, i), Vector(2, i), Real(3, i));
    StoreWord(0, i, similar ? 1 : 0);
}

// ---------------------------------------------------------------- entry points: a frame

[shader("compute")] [numthreads(64, 1, 1)]
void pass_initial(uint3 thread : SV_DispatchThreadID)
{
    uint i = thread.x;
    if (i >= RowCount())
        return;
    float target_pdf = TargetPdf(LoadSurface(0, i), LoadSample(3, i));
    float weight = Ratio(target_pdf, Real(6, i));
    StoreReal(0, i, target_pdf);
    StoreReal(1, i, Ratio(weight, target_pdf));
    StoreReal(2, i, Confidence(weight));
}

[shader("compute")] [numthreads(64, 1, 1)]
void pass_temporal(uint3 thread : SV_DispatchThreadID)
{
    uint i = thread.x;
    if (i >= RowCount())
        return;
    Surface x = LoadSurface(0, i);
    Reservoir r = EmptyReservoir();
    StreamOwn(r, x, LoadReservoir(3, i), 0, 1);
    StreamNew(r, x, LoadSample(8, i), Real(11, i), Real(12, i), 0);
    StoreReservoir(i, r, r.M);
}

[shader("compute")] [numthreads(64, 1, 1)]
void pass_moved(uint3 thread : SV_DispatchThreadID)
{
    uint i = thread.x;
    if (i >= RowCount())
        return;
    Surface x = LoadSurface(0, i);
    Surface x_past = LoadSurface(3, i);
    // Bit 1 is the past sample: seen from here, and what is seen from there.
    bool seen = ((Word(15, 2 * i) >> 1) & 1) == 1;
    uint sees = Word(15, 2 * i + 1);
    Reservoir r = EmptyReservoir();
    StreamShifted(r, x, x_past, LoadReservoir(6, i), seen, 0, 1);
    float M_past = r.M;
    StreamNew(r, x, LoadSample(11, i), Real(14, i), Real(16, i), 0);
    float Z = r.M;
    if (WeightsBySources())
    {
        Z = Planted(CANONICAL_MISSING) ? 0.0 : r.M - M_past;
        if (CouldHaveMade(r, x_past, sees))
            Z += M_past;
    }
    StoreReservoir(i, r, Z);
}

[shader("compute")] [numthreads(64, 1, 1)]
void pass_spatial(uint3 thread : SV_DispatchThreadID)
{
    uint i = thread.x;
    if (i >= RowCount())
        return;
    uint count = NeighborCount();
    uint masks = i * (count + 1);  // who sees which sample: of this pixel, then its neighbours
    Surface x = LoadSurface(0, i);
    Reservoir r = EmptyReservoir();
    StreamOwn(r, x, LoadReservoir(8, i), 0, int(count) + 1);
    StreamOwn(r, x, LoadReservoir(3, i), Real(15, i), 0);
    float Z = Planted(CANONICAL_MISSING) ? Real(12, i) : r.M;
    for (uint k = 0; k < count; k++)
    {
        int neighbor = int(Word(13, i * count + k));
        if (neighbor < 0)
            continue;
        bool seen = ((Word(14, masks) >> (k + 1)) & 1) == 1;
        float random = Real(16, i * count + (Planted(RANDOM_REUSED) ? 0 : k));
        StoredReservoir other = LoadReservoir(3, neighbor);
        if (Planted(M_TIMES_TWO))
            other.W *= 2;
        StreamShifted(r, x, LoadSurface(0, neighbor), other, seen, random, int(k) + 1);
    }
    if (!WeightsBySources())
        Z = r.M;
    // Only now is it known which sample the sources are asked about.
    for (uint k_from = 0; k_from < count && WeightsBySources(); k_from++)
    {
        int neighbor = int(Word(13, i * count + k_from));
        if (neighbor < 0)
            continue;
        bool seen = ((Word(14, masks) >> (k_from + 1)) & 1) == 1;
        bool is_counted = seen || !Planted(HIDDEN_NOT_COUNTED);
        if (is_counted && CouldHaveMade(r, LoadSurface(0, neighbor), Word(14, masks + k_from + 1)))
            Z += Real(7, neighbor);
    }
    StoreReservoir(i, r, Z);
}

[shader("compute")] [numthreads(64, 1, 1)]
void pass_neighbors(uint3 thread : SV_DispatchThreadID)
{
    uint i = thread.x;
    if (i >= RowCount())
        return;
    int2 size = int2(ImageWidth(), int(RowCount()) / ImageWidth());
    int2 pixel = int2(int(i) % size.x, int(i) / size.x);
    float radius = max(FirstRadius() * size.x, LeastRadius());
    for (uint k = 0; k < NeighborCount(); k++)
    {
        uint at = i * NeighborCount() + k;
        float phi = 2 * PI * Real(2, 2 * at + 1);
        float2 offset = radius * sqrt(Real(2, 2 * at)) * float2(cos(phi), sin(phi));
        int2 to = pixel + int2(round(offset));
        bool usable = all(to >= 0) && all(to < size);
        uint row = usable ? uint(to.y * size.x + to.x) : i;
        usable = usable && AreSimilar(Vector(0, i), Real(1, i), Vector(0, row), Real(1, row));
        StoreWord(0, at, usable && row != i ? row : 0xffffffffu);
        if (!usable && !Planted(RADIUS_NOT_HALVED))
            radius = max(radius / 2, LeastRadius());
    }
}

[shader("compute")] [numthreads(64, 1, 1)]
void pass_shade(uint3 thread : SV_DispatchThreadID)
{
    uint i = thread.x;
    if (i >= RowCount())
        return;
    Surface x = LoadSurface(0, i);
    Sample s = LoadSample(3, i);
    float3 brdf = Planted(ALBEDO_MISSING) ? float3(1, 1, 1) : x.albedo;
    if (!Planted(MISSING_ONE_OVER_PI))
        brdf /= PI;
    float3 color = float3(0, 0, 0);
    if (IsLitFromFront(x, s))
        color = brdf * s.radiance * (Real(6, i) * CosineAt(x, s));
    StoreVector(0, i, color);
}
