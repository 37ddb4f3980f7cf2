// A hash grid over the world, built by several threads at once: which thread comes first is
// a matter of luck, and so is the slot of a cell, the place of a vertex in its list, and who
// is lost where a bucket is full.
#pragma once

#include <algorithm>
#include <atomic>
#include <memory>
#include <thread>
#include <vector>

#include "../samples.h"

constexpr size_t SLOTS = 16;
constexpr size_t THREADS = 4;

// Calls `work` with every row, rows side by side in different threads.
template <class Work>
void in_threads(size_t rows, Work work) {
    std::vector<std::thread> threads;
    for (size_t t = 0; t < THREADS; t++)
        threads.emplace_back([=] {
            for (size_t i = t; i < rows; i += THREADS) work(i);
        });
    for (std::thread& thread : threads) thread.join();
}

// Memory that threads count in, or exchange; 0 at first.
template <class T>
class Atomics {
  public:
    explicit Atomics(size_t size) : size_(size), words_(new std::atomic<T>[size]) {
        for (size_t i = 0; i < size; i++) words_[i].store(0);
    }
    std::atomic<T>& operator[](size_t i) { return words_[i]; }
    size_t size() const { return size_; }

  private:
    size_t size_;
    std::unique_ptr<std::atomic<T>[]> words_;
};

// ---------------------------------------------------------------- the cell of a point

inline float edge_of(int32_t level) { return std::ldexp(0.001f, level); }

inline void pass_cell_base(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        float w = static_cast<float>(c.indices("width")[i]);
        float h = static_cast<float>(c.indices("height")[i]);
        float of_pixels = 16 * std::max(1 / h, h / (w * w));
        float angle = std::min(c.reals("fov_y")[i] * of_pixels, 0.25f * PI);
        c.result<float>("base")[i] = std::tan(angle);
    }
}

inline void pass_cell_level(Case& c) {
    bool before = c.is("when", "look-up") && !plant("eye-of-now");
    std::string end = before ? "_before" : "";
    Vec3 eye = {c.number("eye" + end + "_x"), c.number("eye" + end + "_y"),
                c.number("eye" + end + "_z")};
    float base = c.number("base" + end);
    for (size_t i = 0; i < c.rows; i++) {
        float edges = 1000 * length(c.vectors("position")[i] - eye) * base;
        float level = edges > 1 ? std::floor(std::log2(edges)) : 0;
        c.result<int32_t>("level")[i] = static_cast<int32_t>(level);
    }
}

inline void pass_cell_jitter(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        Vec3 n = c.vectors("normal")[i];
        // Any frame about n: start from an axis that is not along it.
        Vec3 t = normalized(cross(std::fabs(n.x) < 0.6f ? Vec3{1, 0, 0} : Vec3{0, 1, 0}, n));
        Vec3 b = cross(n, t);
        float reach = std::sqrt(2.0f) * edge_of(c.indices("level")[i]);
        const float* u = c.reals("u") + 2 * i;
        c.result<Vec3>("moved")[i] = c.vectors("position")[i] + (reach * (2 * u[0] - 1)) * t +
                                     (reach * (2 * u[1] - 1)) * b;
    }
}

inline void pass_cell_key(Case& c) {
    int32_t parts = c.whole("facings");
    auto part = [parts](float x) {
        int32_t k = static_cast<int32_t>(std::floor((x + 1) * (0.5f * static_cast<float>(parts))));
        return std::min(std::max(k, 0), parts - 1);
    };
    auto whole = [](float x) { return static_cast<int32_t>(std::floor(x)); };
    for (size_t i = 0; i < c.rows; i++) {
        Vec3 p = (1 / edge_of(c.indices("level")[i])) * c.vectors("position")[i];
        Vec3 n = c.vectors("normal")[i];
        c.result<int32_t>("x")[i] = whole(p.x);
        c.result<int32_t>("y")[i] = whole(p.y);
        c.result<int32_t>("z")[i] = whole(p.z);
        c.result<int32_t>("facing")[i] = part(n.x) + parts * (part(n.y) + parts * part(n.z));
    }
}

inline uint32_t pcg(uint32_t v) {
    uint32_t s = v * 747796405u + 2891336453u;
    uint32_t w = ((s >> ((s >> 28) + 4)) ^ s) * 277803737u;
    return (w >> 22) ^ w;
}

inline uint32_t xxhash32(uint32_t v) {
    uint32_t s = v + 374761393u;
    s = ((s << 17) | (s >> 15)) * 668265263u;
    s = (s ^ (s >> 15)) * 2246822519u;
    s = (s ^ (s >> 13)) * 3266489917u;
    return s ^ (s >> 16);
}

inline void pass_cell_hash(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        uint32_t hash = 0, check = 0;
        for (const char* field : {"facing", "z", "y", "x", "level"}) {
            uint32_t word = static_cast<uint32_t>(c.indices(field)[i]);
            hash = pcg(word + hash);
            check = xxhash32(word + check);
        }
        c.result<uint32_t>("bucket_hash")[i] = hash;
        c.result<uint32_t>("checksum")[i] = std::max(check, 1u);
    }
}

// ---------------------------------------------------------------- Algorithm 2

// Checksums of cells; 0 is a free slot.
inline int32_t find_or_insert(Atomics<uint32_t>& table, size_t bucket, uint32_t checksum) {
    for (size_t at = bucket * SLOTS; at < (bucket + 1) * SLOTS; at++) {
        uint32_t there = 0;
        bool won = table[at].compare_exchange_strong(there, checksum);
        // Where another thread was first, `there` is what it has left.
        bool same = there == checksum || plant("checksum-missing");
        if (won || (same && !plant("insertion-lost"))) return static_cast<int32_t>(at);
        if (same) return -1;
    }
    return -1;
}

inline void pass_cell_insert(Case& c) {
    size_t buckets = static_cast<size_t>(c.whole("buckets"));
    Atomics<uint32_t> table(buckets * SLOTS);
    const uint32_t *hash = c.bits("bucket_hash"), *checksum = c.bits("checksum");
    const uint32_t* active = c.bits("active");
    int32_t* slot = c.result<int32_t>("slot");
    in_threads(c.rows, [&, buckets, hash, checksum, active, slot](size_t i) {
        slot[i] = active[i] ? find_or_insert(table, hash[i] % buckets, checksum[i]) : -1;
    });
}

inline void pass_cell_count(Case& c) {
    Atomics<int32_t> counters(c.rows);
    const int32_t* slot = c.indices("slot");
    int32_t* place = c.result<int32_t>("place");
    in_threads(c.rows, [&, slot, place](size_t i) {
        place[i] = slot[i] < 0 ? -1 : counters[static_cast<size_t>(slot[i])].fetch_add(1);
    });
    for (size_t i = 0; i < c.rows; i++) c.result<int32_t>("counter")[i] = counters[i].load();
}

inline void pass_cell_scan(Case& c) {
    int32_t sum = 0;
    for (size_t i = 0; i < c.rows; i++) {
        int32_t counter = c.indices("counter")[i];
        c.result<int32_t>("start")[i] = plant("scan-inclusive") ? sum + counter : sum;
        sum += counter;
    }
}

inline void pass_cell_scatter(Case& c) {
    const int32_t *slot = c.indices("slot"), *place = c.indices("place");
    const int32_t* start = c.indices("start");
    int32_t* storage = c.result<int32_t>("storage");
    in_threads(c.rows, [=](size_t i) {
        if (slot[i] >= 0) storage[start[slot[i]] + place[i]] = static_cast<int32_t>(i);
    });
}

// ---------------------------------------------------------------- the look-up

inline void pass_cell_find(Case& c) {
    size_t buckets = static_cast<size_t>(c.whole("buckets"));
    const uint32_t* table = c.bits("table");
    for (size_t i = 0; i < c.rows; i++) {
        size_t first = c.bits("bucket_hash")[i] % buckets * SLOTS;
        int32_t found = -1;
        for (size_t at = first; at < first + SLOTS && found < 0 && table[at] != 0; at++)
            if (table[at] == c.bits("checksum")[i] || plant("checksum-missing"))
                found = static_cast<int32_t>(at);
        c.result<int32_t>("slot")[i] = found;
    }
}

constexpr int32_t COLUMNS = 8;

inline void pass_cell_visit(Case& c) {
    int32_t most = c.whole("most");
    for (size_t i = 0; i < c.rows; i++) {
        int32_t slot = c.indices("slot")[i];
        int32_t n = slot < 0 ? 0 : c.indices("counter")[slot];
        int32_t begin = static_cast<int32_t>(c.reals("u")[i] * static_cast<float>(n));
        for (int32_t k = 0; k < COLUMNS; k++) {
            int32_t& vertex = c.result<int32_t>("vertex")[i * COLUMNS + static_cast<size_t>(k)];
            vertex = -1;
            // Neighbours in the list; any walk will do that takes all equally often.
            if (k < std::min(most, n))
                vertex = c.indices("storage")[c.indices("start")[slot] + (begin + k) % n];
        }
    }
}

inline void pass_cell_similar(Case& c) {
    for (size_t i = 0; i < c.rows; i++) {
        float cosine = std::max(dot(c.vectors("normal_a")[i], c.vectors("normal_b")[i]), 0.0f);
        c.result<uint32_t>("similar")[i] = cosine * cosine * cosine * cosine >= 0.5f;
    }
}

inline const PassTable HASH_GRID_PASSES = {
    {"cell_base", pass_cell_base},       {"cell_level", pass_cell_level},
    {"cell_jitter", pass_cell_jitter},   {"cell_key", pass_cell_key},
    {"cell_hash", pass_cell_hash},       {"cell_insert", pass_cell_insert},
    {"cell_count", pass_cell_count},     {"cell_scan", pass_cell_scan},
    {"cell_scatter", pass_cell_scatter}, {"cell_find", pass_cell_find},
    {"cell_visit", pass_cell_visit},     {"cell_similar", pass_cell_similar}};
