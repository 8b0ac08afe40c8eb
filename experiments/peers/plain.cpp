// The five-point leapfrog as one writes it down: a square f32 field, no walls, no layers, no source.
//
//     g++ -O3 -march=native -ffast-math -fopenmp plain.cpp -o plain && ./plain CELLS STEPS THREADS
//
// Prints Gcell/s.
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <utility>
#include <vector>

#include <omp.h>

int main(int count, char **arguments) {
    if (count != 4) {
        std::fprintf(stderr, "usage: plain CELLS STEPS THREADS\n");
        return 2;
    }
    const long cells = std::atol(arguments[1]);
    const long steps = std::atol(arguments[2]);
    omp_set_num_threads(std::atoi(arguments[3]));
    const float square = 0.32f, centre = 2.0f - 4.0f * square;
    std::vector<float> one(cells * cells), other(cells * cells);
    for (long i = 0; i < cells * cells; ++i)
        one[i] = 1e-3f * float(i * 37 % 101);
    float *now = one.data(), *past = other.data();
    const auto start = std::chrono::steady_clock::now();
    for (long step = 0; step < steps; ++step) {
#pragma omp parallel for schedule(static)
        for (long y = 1; y < cells - 1; ++y) {
            const float *row = now + y * cells;
            float *next = past + y * cells;
#pragma omp simd
            for (long x = 1; x < cells - 1; ++x) {
                const float sides = (row[x - 1] + row[x + 1]) + (row[x - cells] + row[x + cells]);
                next[x] = centre * row[x] + square * sides - next[x];
            }
        }
        std::swap(now, past);
    }
    const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
    // Printed so that nothing is left out as useless.
    std::fprintf(stderr, "%g\n", now[cells * cells / 2]);
    std::printf("%.4f\n", 1e-9 * double(cells) * double(cells) * double(steps) / taken.count());
}
