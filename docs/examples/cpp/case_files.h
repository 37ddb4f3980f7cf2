// Cases as files: cases.txt, and a file of bare numbers for each buffer.
#pragma once

#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iostream>
#include <map>
#include <sstream>
#include <string>
#include <vector>

#include "vectors.h"

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

    const float* reals(const std::string& name) const { return numbers<float>(name); }
    const Vec3* vectors(const std::string& name) const { return numbers<Vec3>(name); }
    const uint32_t* bits(const std::string& name) const { return numbers<uint32_t>(name); }
    const int32_t* indices(const std::string& name) const { return numbers<int32_t>(name); }
    size_t columns(const std::string& name) const { return in.at(name).shape[1]; }

    template <class T>
    T* result(const std::string& name) {
        return reinterpret_cast<T*>(out.at(name).bytes.data());
    }
    float number(const std::string& name) const {
        return std::strtof(settings.at(name).c_str(), nullptr);
    }
    // Seeds and frames have up to 27 bits, of which a float keeps 24.
    int32_t whole(const std::string& name) const {
        return static_cast<int32_t>(std::strtod(settings.at(name).c_str(), nullptr));
    }
    bool is(const std::string& name, const char* value) const {
        return settings.at(name) == value;
    }

  private:
    template <class T>
    const T* numbers(const std::string& name) const {
        return reinterpret_cast<const T*>(in.at(name).bytes.data());
    }
};

using Pass = void (*)(Case&);
using PassTable = std::map<std::string, Pass>;

[[noreturn]] inline void fail(const std::string& text) {
    std::cerr << "restir_backend: " << text << "\n";
    std::exit(2);
}

// Name, type, shape and path of a buffer, as a line of the index has them.
inline Buffer described(std::istringstream& words) {
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

inline void read(Buffer& buffer, const std::string& folder) {
    std::ifstream file(folder + "/" + buffer.path, std::ios::binary);
    file.read(buffer.bytes.data(), static_cast<std::streamsize>(buffer.bytes.size()));
    if (!file) fail("cannot read " + buffer.path);
}

inline void write(const Buffer& buffer, const std::string& folder) {
    std::ofstream file(folder + "/" + buffer.path, std::ios::binary);
    file.write(buffer.bytes.data(), static_cast<std::streamsize>(buffer.bytes.size()));
    if (!file) fail("cannot write " + buffer.path);
}

inline void run(Case& c, const PassTable& passes, const std::string& folder) {
    auto pass = passes.find(c.pass);
    if (pass == passes.end()) return;  // what is not written is not judged
    pass->second(c);
    for (const auto& [name, buffer] : c.out) write(buffer, folder);
}

inline void run_all(const PassTable& passes, const std::string& folder) {
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
            read(b, folder);
            c.in[b.name] = std::move(b);
        } else if (word == "out" || word == "may") {
            Buffer b = described(words);
            c.out[b.name] = std::move(b);
        } else if (word == "end") {
            run(c, passes, folder);
        }
    }
}
