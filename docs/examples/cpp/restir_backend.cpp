// A backend in plain C++17: scalar loops, single precision, one function a pass.
//
//     g++ -O2 -std=c++17 -pthread -o restir_backend restir_backend.cpp
//     restir check './restir_backend {directory}'
//
// It is written from the contract alone (docs/reference/contract.md).  With
// `--plant NAME` it makes one mistake that others have made; `--list-plants` lists them.

#include <algorithm>
#include <iostream>
#include <iterator>
#include <string>

#include "case_files.h"
#include "mistakes.h"
#include "passes/camera.h"
#include "passes/cell_contents.h"
#include "passes/filters.h"
#include "passes/gradient_domain.h"
#include "passes/hash_grid.h"
#include "passes/kernels.h"
#include "passes/neighbors.h"
#include "passes/packing.h"
#include "passes/path_reuse.h"
#include "passes/path_shift.h"
#include "passes/poisson.h"
#include "passes/random.h"
#include "passes/resampling.h"
#include "passes/shading.h"
#include "passes/sparing.h"

// Each header of passes has a table of its own; further passes come in here.
static PassTable all_passes() {
    PassTable all;
    for (const PassTable& table :
         {RANDOM_PASSES, KERNEL_PASSES, NEIGHBOR_PASSES, RESAMPLING_PASSES, SHADING_PASSES,
          CAMERA_PASSES, FILTER_PASSES, SPARING_PASSES, PACKING_PASSES, PATH_REUSE_PASSES,
          PATH_SHIFT_PASSES, HASH_GRID_PASSES, CELL_CONTENT_PASSES, GRADIENT_DOMAIN_PASSES,
          POISSON_PASSES})
        all.insert(table.begin(), table.end());
    return all;
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
    run_all(all_passes(), folder);
    return 0;
}
