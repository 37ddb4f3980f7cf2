// A backend in plain C++17: scalar loops, single precision, one function a pass.
//
//     g++ -O2 -std=c++17 -o restir_backend restir_backend.cpp
//     restir check './restir_backend {directory}'
//
// It is written from the contract alone (docs/reference/contract.md).  With
// `--plant NAME` it makes one mistake that others have made; `--list-plants` lists them.

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

// ---------------------------------------------------------------- mistakes

static std::string planted;

static bool plant(const char* name) { return planted == name; }

static const char* const PLANTS[] = {
    "jacobian-divided", "jacobian-omitted", "jacobian-unsquared",
    "jacobian-receiver-cosine", "jacobian-clamped", "cosine-omitted", "cosine-twice",
    "missing-one-over-pi", "one-over-m", "nulls-not-counted", "m-times-two",
    "cap-missing", "confidence-missing", "source-target", "canonical-missing",
    "visibility-ignored-in-z", "visibility-ignored-in-weight", "hidden-not-counted",
    "accept-old-sum", "wrong-pdf", "random-reused", "depth-relative-to-own",
    "radius-not-halved", "albedo-missing", "cap-before-weight"};

// ---------------------------------------------------------------- vectors

struct Vec3 {
    float x, y, z;
};

static Vec3 operator+(Vec3 a, Vec3 b) { return {a.x + b.x, a.y + b.y, a.z + b.z}; }
static Vec3 operator-(Vec3 a, Vec3 b) { return {a.x - b.x, a.y - b.y, a.z - b.z}; }
static Vec3 operator*(Vec3 a, Vec3 b) { return {a.x * b.x, a.y * b.y, a.z * b.z}; }
static Vec3 operator*(float s, Vec3 a) { return {s * a.x, s * a.y, s * a.z}; }
static float dot(Vec3 a, Vec3 b) { return a.x * b.x + a.y * b.y + a.z * b.z; }
static float over(float a, float b) { return b != 0 ? a / b : 0.0f; }

static float luminance(Vec3 c) {
    return 0.2126f * c.x + 0.7152f * c.y + 0.0722f * c.z;
}

static const float PI = 3.14159265358979f;

// ---------------------------------------------------------------- buffers of a case

struct Buffer {
    std::string name, type, path;
    std::vector<size_t> shape;
    std::vector<char> bytes;

    size_t count() const {
        size_t n = 1;
        for (size_t size : shape) n *= size;
        return n;
    }
};

struct Case {
    std::string name, pass;
    size_t rows = 0;
    std::map<std::string, std::string> settings;
    std::map<std::string, Buffer> in, out;

    const float* reals(const std::string& name) const {
        return reinterpret_cast<const float*>(in.at(name).bytes.data());
    }
    const Vec3* vectors(const std::string& name) const {
        return reinterpret_cast<const Vec3*>(in.at(name).bytes.data());
    }
    const uint32_t* bits(const std::string& name) const {
        return reinterpret_cast<const uint32_t*>(in.at(name).bytes.data());
    }
    const int32_t* indices(const std::string& name) const {
        return reinterpret_cast<const int32_t*>(in.at(name).bytes.data());
    }
    template <class T>
    T* result(const std::string& name) {
        return reinterpret_cast<T*>(out.at(name).bytes.data());
    }
    float number(const std::string& name) const {
        return std::strtof(settings.at(name).c_str(), nullptr);
    }
    bool is(const std::string& name, const char* value) const {
        return settings.at(name) == value;
    }
};

// ---------------------------------------------------------------- formulas

struct Receiver {
    Vec3 position, normal, albedo;
};

struct Sample {
    Vec3 position, normal, radiance;
};

struct Reservoir {
    Sample y;
    float W, M;
};

static float planted_cosine(float cosine) {
    return plant("cosine-omitted") ? 1 : plant("cosine-twice") ? cosine * cosine : cosine;
}

// Target of Equation 9 or 10; 0 below the horizon and on the unlit side.
static float target(bool outgoing, const Receiver& x, const Sample& y) {
    Vec3 v = y.position - x.position;
    if (dot(x.normal, v) <= 0 || dot(y.normal, v) >= 0) return 0;
    if (outgoing) return luminance(y.radiance);
    // 0 where the square of the distance is too small for single precision.
    float cosine = planted_cosine(over(dot(x.normal, v), std::sqrt(dot(v, v))));
    float pi = plant("missing-one-over-pi") ? 1 : PI;
    return luminance(x.albedo * y.radiance) / pi * cosine;
}

// Equation 11: |d omega_to / d omega_from|.
static float jacobian(const Receiver& from, const Receiver& to, const Sample& y) {
    if (plant("jacobian-omitted")) return 1;
    Vec3 v = from.position - y.position, w = to.position - y.position;
    float d_from = dot(v, v), d_to = dot(w, w);
    if (d_from == 0 || d_to == 0) return 0;
    float cosine_from = std::fabs(dot(y.normal, v)) / std::sqrt(d_from);
    float cosine_to = std::fabs(dot(y.normal, w)) / std::sqrt(d_to);
    if (plant("jacobian-receiver-cosine")) {
        cosine_from = std::fabs(dot(from.normal, v)) / std::sqrt(d_from);
        cosine_to = std::fabs(dot(to.normal, w)) / std::sqrt(d_to);
    }
    float ratio = d_from / d_to;
    if (plant("jacobian-unsquared")) ratio = std::sqrt(ratio);
    float J = over(cosine_to, cosine_from) * ratio;
    if (plant("jacobian-divided")) return over(1, J);
    if (plant("jacobian-clamped")) return std::min(std::max(J, 1.0f / 3), 3.0f);
    return std::isfinite(J) ? J : 0;
}

static bool keeps(float u, float before, float w) {
    if (before == 0) return w > 0;
    if (plant("accept-old-sum")) return u * before < w;
    return u * (before + w) < w;
}

static bool similar(Vec3 n_a, float z_a, Vec3 n_b, float z_b, float cosine, float depth) {
    float scale = plant("depth-relative-to-own") ? z_a : std::max(z_a, z_b);
    return z_a > 0 && z_b > 0 && dot(n_a, n_b) >= cosine &&
           std::fabs(z_a - z_b) <= depth * scale;
}

static float limit_cosine(const Case& c) {
    return static_cast<float>(std::cos(c.number("max_angle") * 3.14159265358979 / 180));
}

// ---------------------------------------------------------------- kernels

static void pass_random(Case& c) {
    const uint32_t* key = c.bits("key");
    uint32_t* words = c.result<uint32_t>("words");
    float* u = c.result<float>("u");
    for (size_t i = 0; i < c.rows; i++) {
        uint32_t v[4];
        for (int k = 0; k < 4; k++) v[k] = key[4 * i + k] * 1664525u + 1013904223u;
        for (int round = 0; round < 2; round++) {
            v[0] += v[1] * v[3];
            v[1] += v[2] * v[0];
            v[2] += v[0] * v[1];
            v[3] += v[1] * v[2];
            if (round == 0)
                for (uint32_t& word : v) word ^= word >> 16;
        }
        for (int k = 0; k < 4; k++) {
            words[4 * i + k] = v[k];
            u[4 * i + k] = static_cast<float>(v[k] >> 8) * 0x1p-24f;
        }
    }
}

static void pass_direction(Case& c) {
    const Vec3* normal = c.vectors("visible_normal");
    const float* u = c.reals("u");
    Vec3* direction = c.result<Vec3>("direction");
    float* pdf = c.result<float>("pdf");
    bool uniform = c.is("source", "uniform");
    for (size_t i = 0; i < c.rows; i++) {
        Vec3 n = normal[i];
        // Any frame about n: start from the axis that is least along it.
        Vec3 axis = std::fabs(n.x) < 0.6f ? Vec3{1, 0, 0} : Vec3{0, 1, 0};
        Vec3 t = axis - dot(axis, n) * n;
        t = (1 / std::sqrt(dot(t, t))) * t;
        Vec3 b = {n.y * t.z - n.z * t.y, n.z * t.x - n.x * t.z, n.x * t.y - n.y * t.x};
        float cosine = uniform ? u[2 * i] : std::sqrt(1 - u[2 * i]);
        float sine = uniform ? std::sqrt((1 - cosine) * (1 + cosine)) : std::sqrt(u[2 * i]);
        float phi = 2 * PI * u[2 * i + 1];
        direction[i] = (sine * std::cos(phi)) * t + (sine * std::sin(phi)) * b + cosine * n;
        pdf[i] = uniform ? 1 / (plant("wrong-pdf") ? PI : 2 * PI) : cosine / PI;
    }
}

static Receiver receiver(const Case& c, size_t i, const std::string& prefix = "") {
    return {c.vectors(prefix + "visible_position")[i],
            c.vectors(prefix + "visible_normal")[i], c.vectors(prefix + "albedo")[i]};
}

static Sample sample(const Case& c, size_t i, const std::string& prefix = "") {
    return {c.vectors(prefix + "position")[i], c.vectors(prefix + "normal")[i],
            c.vectors(prefix + "radiance")[i]};
}

static Reservoir reservoir(const Case& c, size_t i, const std::string& prefix = "") {
    return {sample(c, i, prefix), c.reals(prefix + "W")[i], c.reals(prefix + "M")[i]};
}

static void pass_target(Case& c) {
    float* p_hat = c.result<float>("p_hat");
    bool outgoing = c.is("target", "outgoing");
    for (size_t i = 0; i < c.rows; i++)
        p_hat[i] = target(outgoing, receiver(c, i), sample(c, i));
}

static void pass_jacobian(Case& c) {
    float* J = c.result<float>("jacobian");
    for (size_t i = 0; i < c.rows; i++) {
        Vec3 n = c.vectors("normal")[i];
        Receiver from = {c.vectors("x_from")[i], n, n}, to = {c.vectors("x_to")[i], n, n};
        J[i] = jacobian(from, to, {c.vectors("position")[i], n, n});
    }
}

static void pass_merge(Case& c) {
    uint32_t* second = c.result<uint32_t>("second");
    float *w = c.result<float>("w"), *M = c.result<float>("M");
    const float *w_a = c.reals("w_a"), *w_b = c.reals("w_b"), *u = c.reals("u");
    for (size_t i = 0; i < c.rows; i++) {
        second[i] = keeps(u[i], w_a[i], w_b[i]);
        w[i] = w_a[i] + w_b[i];
        M[i] = c.reals("M_a")[i] + c.reals("M_b")[i];
    }
}

static void pass_finalize(Case& c) {
    float* W = c.result<float>("W");
    for (size_t i = 0; i < c.rows; i++) {
        W[i] = over(over(c.reals("w")[i], c.reals("p_hat")[i]), c.reals("Z")[i]);
        W[i] = std::min(W[i], 3.4028234e38f);
    }
}

static void pass_similar(Case& c) {
    uint32_t* out = c.result<uint32_t>("similar");
    for (size_t i = 0; i < c.rows; i++)
        out[i] = similar(c.vectors("normal_a")[i], c.reals("depth_a")[i],
                         c.vectors("normal_b")[i], c.reals("depth_b")[i],
                         limit_cosine(c), c.number("max_depth"));
}

// ---------------------------------------------------------------- streams

// One competitor: its sample, weight and confidence, and where else it stands.
struct Entry {
    Sample y;
    float p_hat, w, M, u;
    bool elsewhere;
    Receiver x;
    uint32_t sees;  // who sees which sample, from x
    int bit;        // of its own sample
};

struct Stream {
    std::vector<Entry> entries;
    int kept = 0;
    float total = 0;
};

static void choose(Stream& s) {
    s.total = s.entries[0].w;
    for (size_t k = 1; k < s.entries.size(); k++) {
        const Entry& e = s.entries[k];
        if (keeps(e.u, s.total, e.w)) s.kept = static_cast<int>(k);
        s.total += e.w;
    }
}

static void close(Case& c, size_t i, const Stream& s, const std::string& mis, size_t canonical) {
    const Entry& kept = s.entries[s.kept];
    bool outgoing = c.is("target", "outgoing");
    float M = 0, Z = 0;
    for (size_t k = 0; k < s.entries.size(); k++) {
        const Entry& e = s.entries[k];
        M += e.M;
        if (!e.elsewhere) {
            if (!(plant("canonical-missing") && k == canonical)) Z += e.M;
            continue;
        }
        bool seen = (e.sees >> kept.bit) & 1u;
        if (plant("visibility-ignored-in-z")) seen = true;
        if (seen && target(outgoing, e.x, kept.y) > 0) Z += e.M;
    }
    if (mis == "1/M" || plant("one-over-m")) Z = M;
    if (plant("cap-before-weight")) Z = std::min(Z, c.number("cap"));
    float p_hat = kept.p_hat;
    if (plant("source-target") && kept.elsewhere) p_hat = target(outgoing, kept.x, kept.y);
    // Terms for the report.
    float* weights = c.result<float>("term_w");
    for (size_t k = 0; k < s.entries.size(); k++) weights[i * s.entries.size() + k] = s.entries[k].w;
    c.result<float>("term_p_hat")[i] = p_hat;
    c.result<float>("term_Z")[i] = Z;
    c.result<Vec3>("position")[i] = kept.y.position;
    c.result<Vec3>("normal")[i] = kept.y.normal;
    c.result<Vec3>("radiance")[i] = kept.y.radiance;
    c.result<float>("W")[i] = over(over(s.total, p_hat), Z);
    c.result<float>("M")[i] = plant("cap-missing") ? M : std::min(M, c.number("cap"));
}

static float confidence(float w) { return plant("nulls-not-counted") && !(w > 0) ? 0.0f : 1.0f; }

static Entry fresh(const Case& c, size_t i, const Receiver& x, int bit) {
    Sample y = sample(c, i, "new_");
    float p_hat = target(c.is("target", "outgoing"), x, y);
    float w = over(p_hat, c.reals("new_pdf")[i]);
    return {y, p_hat, w, confidence(w), c.reals("u")[i], false, x, 0, bit};
}

static Entry reused(const Case& c, const Receiver& x, const Reservoir& r, float u, int bit) {
    float p_hat = target(c.is("target", "outgoing"), x, r.y);
    float M = plant("confidence-missing") ? 1 : r.M;
    return {r.y, p_hat, p_hat * r.W * M, r.M, u, false, x, 0, bit};
}

// A reservoir of another point x_from, seen from x.
static Entry shifted(const Case& c, const Receiver& x, const Receiver& x_from,
                     const Reservoir& r, float u, int bit, bool seen, uint32_t sees) {
    Entry e = reused(c, x, r, u, bit);
    e.elsewhere = true;
    e.x = x_from;
    e.sees = sees;
    e.w = e.w > 0 ? e.w * jacobian(x_from, x, r.y) : 0;
    if (!seen && !plant("visibility-ignored-in-weight")) e.w = 0;
    if (!seen && plant("hidden-not-counted")) e.M = 0;
    return e;
}

static void pass_initial(Case& c) {
    bool outgoing = c.is("target", "outgoing");
    for (size_t i = 0; i < c.rows; i++) {
        float p_hat = target(outgoing, receiver(c, i), sample(c, i));
        float w = over(p_hat, c.reals("pdf")[i]);
        c.result<float>("p_hat")[i] = p_hat;
        c.result<float>("W")[i] = over(w, p_hat);
        c.result<float>("M")[i] = confidence(w);
    }
}

static void pass_temporal(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        Receiver x = receiver(c, i);
        Stream s;
        s.entries = {reused(c, x, reservoir(c, i, "past_"), 0, 1), fresh(c, i, x, 0)};
        choose(s);
        close(c, i, s, "1/M", 1);
    }
}

static void pass_moved(Case& c) {
    const uint32_t* visible = c.bits("visible");
    for (size_t i = 0; i < c.rows; i++) {
        Receiver x = receiver(c, i), x_past = receiver(c, i, "past_");
        bool seen = (visible[2 * i] >> 1) & 1u;
        Stream s;
        s.entries = {shifted(c, x, x_past, reservoir(c, i, "past_"), 0, 1, seen, visible[2 * i + 1]),
                     fresh(c, i, x, 0)};
        choose(s);
        close(c, i, s, c.settings.at("mis"), 1);
    }
}

static void pass_spatial(Case& c) {
    size_t count = c.in.at("neighbors").shape[1];
    const int32_t* neighbors = c.indices("neighbors");
    const uint32_t* visible = c.bits("visible");
    const float* u = c.reals("u_neighbors");
    for (size_t i = 0; i < c.rows; i++) {
        Receiver x = receiver(c, i);
        int past_bit = static_cast<int>(count) + 1;
        Stream s;
        s.entries.push_back(reused(c, x, reservoir(c, i, "past_"), 0, past_bit));
        s.entries.push_back(reused(c, x, reservoir(c, i), c.reals("u_own")[i], 0));
        const uint32_t* sees = visible + i * (count + 1);
        for (size_t k = 0; k < count; k++) {
            int32_t row = neighbors[i * count + k];
            if (row < 0) {
                s.entries.push_back({{}, 0, 0, 0, 0, false, x, 0, 0});
                continue;
            }
            int bit = static_cast<int>(k) + 1;
            bool seen = (sees[0] >> bit) & 1u;
            float number = u[i * count + (plant("random-reused") ? 0 : k)];
            Entry e = shifted(c, x, receiver(c, row), reservoir(c, row), number, bit, seen, sees[1 + k]);
            if (plant("m-times-two")) e.w *= 2;
            s.entries.push_back(e);
        }
        choose(s);
        close(c, i, s, c.settings.at("mis"), 1);
    }
}

static void pass_neighbors(Case& c) {
    const Vec3* normal = c.vectors("visible_normal");
    const float *depth = c.reals("depth"), *u = c.reals("u");
    int32_t* out = c.result<int32_t>("neighbors");
    size_t count = c.in.at("u").shape[1];
    int width = static_cast<int>(c.number("width"));
    int height = static_cast<int>(c.rows) / width;
    float least = c.number("min_radius");
    for (size_t i = 0; i < c.rows; i++) {
        int x = static_cast<int>(i) % width, y = static_cast<int>(i) / width;
        float radius = std::max(c.number("radius") * width, least);
        for (size_t k = 0; k < count; k++) {
            const float* numbers = u + (i * count + k) * 2;
            float r = radius * std::sqrt(numbers[0]), phi = 2 * PI * numbers[1];
            int x_to = x + static_cast<int>(std::nearbyint(r * std::cos(phi)));
            int y_to = y + static_cast<int>(std::nearbyint(r * std::sin(phi)));
            bool usable = x_to >= 0 && x_to < width && y_to >= 0 && y_to < height;
            size_t row = usable ? static_cast<size_t>(y_to) * width + x_to : i;
            usable = usable && similar(normal[i], depth[i], normal[row], depth[row],
                                       limit_cosine(c), c.number("max_depth"));
            out[i * count + k] = usable && row != i ? static_cast<int32_t>(row) : -1;
            if (!usable && !plant("radius-not-halved")) radius = std::max(radius / 2, least);
        }
    }
}

static void pass_shade(Case& c) {
    Vec3* color = c.result<Vec3>("color");
    for (size_t i = 0; i < c.rows; i++) {
        Receiver x = receiver(c, i);
        Sample y = sample(c, i);
        Vec3 v = y.position - x.position;
        Vec3* f = c.result<Vec3>("term_f") + i;
        color[i] = *f = {0, 0, 0};
        if (dot(x.normal, v) <= 0 || dot(y.normal, v) >= 0) continue;
        float cosine = planted_cosine(dot(x.normal, v) / std::sqrt(dot(v, v)));
        float pi = plant("missing-one-over-pi") ? 1 : PI;
        Vec3 albedo = plant("albedo-missing") ? Vec3{1, 1, 1} : x.albedo;
        *f = (cosine / pi) * (albedo * y.radiance);
        color[i] = c.reals("W")[i] * *f;
    }
}

// ---------------------------------------------------------------- files

using Pass = void (*)(Case&);

static const std::map<std::string, Pass> PASSES = {
    {"random", pass_random},     {"direction", pass_direction}, {"target", pass_target},
    {"jacobian", pass_jacobian}, {"merge", pass_merge},         {"finalize", pass_finalize},
    {"similar", pass_similar},   {"initial", pass_initial},     {"temporal", pass_temporal},
    {"moved", pass_moved},       {"neighbors", pass_neighbors}, {"spatial", pass_spatial},
    {"shade", pass_shade}};

[[noreturn]] static void fail(const std::string& text) {
    std::cerr << "restir_backend: " << text << "\n";
    std::exit(2);
}

static Buffer described(std::istringstream& words) {
    Buffer b;
    size_t dimensions = 0;
    words >> b.name >> b.type >> dimensions;
    for (size_t k = 0; k < dimensions; k++) {
        size_t size = 0;
        words >> size;
        b.shape.push_back(size);
    }
    words >> b.path;
    b.bytes.resize(b.count() * 4);
    return b;
}

static void run(Case& c, const std::string& folder) {
    auto pass = PASSES.find(c.pass);
    if (pass == PASSES.end()) return;  // what is not written is not judged
    pass->second(c);
    for (auto& [name, buffer] : c.out) {
        std::ofstream file(folder + "/" + buffer.path, std::ios::binary);
        file.write(buffer.bytes.data(), static_cast<std::streamsize>(buffer.bytes.size()));
        if (!file) fail("cannot write " + buffer.path);
    }
}

static void run_all(const std::string& folder) {
    std::ifstream index(folder + "/cases.txt");
    if (!index) fail("no cases.txt in " + folder);
    Case c;
    for (std::string line; std::getline(index, line);) {
        std::istringstream words(line);
        std::string word, name, value;
        words >> word;
        if (word == "precision") {
            words >> value;
            if (value != "float32") fail("precision " + value + "; this is single precision");
        } else if (word == "case") {
            c = Case();
            words >> c.name >> c.pass >> c.rows;
        } else if (word == "set") {
            words >> name >> value;
            c.settings[name] = value;
        } else if (word == "in") {
            Buffer b = described(words);
            std::ifstream file(folder + "/" + b.path, std::ios::binary);
            file.read(b.bytes.data(), static_cast<std::streamsize>(b.bytes.size()));
            if (!file) fail("cannot read " + b.path);
            c.in[b.name] = std::move(b);
        } else if (word == "out" || word == "may") {
            Buffer b = described(words);
            c.out[b.name] = std::move(b);
        } else if (word == "end") {
            run(c, folder);
        }
    }
}

int main(int count, char** words) {
    std::string folder;
    for (int k = 1; k < count; k++) {
        std::string word = words[k];
        if (word == "--list-plants") {
            for (const char* name : PLANTS) std::cout << name << "\n";
            return 0;
        }
        if (word == "--plant" && k + 1 < count)
            planted = words[++k];
        else
            folder = word;
    }
    auto known = [](const char* name) { return plant(name); };
    if (!planted.empty() && std::none_of(std::begin(PLANTS), std::end(PLANTS), known))
        fail("no plant " + planted + "; see --list-plants");
    if (folder.empty()) fail("name a folder with cases.txt");
    run_all(folder);
    return 0;
}
