// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/texture.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "datasets/synthetic/hash.h"

// Highway compiles this file once per instruction set. Only IEEE operations are used, so that all give the
// same bits.
#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "datasets/synthetic/texture.cpp"
#include <hwy/foreach_target.h>
#include <hwy/highway.h>

HWY_BEFORE_NAMESPACE();
namespace terrace::synthetic::HWY_NAMESPACE {
namespace hn = hwy::HWY_NAMESPACE;

using Floats = hn::ScalableTag<float>;
using Ints = hn::Rebind<std::int32_t, Floats>;
using Words = hn::Rebind<std::uint32_t, Floats>;
using Vf = hn::Vec<Floats>;
using Vi = hn::Vec<Ints>;
using Vw = hn::Vec<Words>;

/// Between these pixel sizes, in lattice cells of the noise, an octave fades out.
constexpr float kFadeStart = 0.6F;
constexpr float kFadeEnd = 1.4F;
constexpr float kLacunarity = 2.2F;
constexpr float kFinest = 2000.0F;  // lattice cells a metre
/// Standard deviation of one octave of Noise.
constexpr float kNoiseSigma = 0.37F;

inline Vf Set(float value) { return hn::Set(Floats(), value); }
inline Vf Clamp01(Vf x) { return hn::Min(hn::Max(x, Set(0.0F)), Set(1.0F)); }
inline Vf Mix(Vf a, Vf b, Vf t) { return hn::Add(a, hn::Mul(hn::Sub(b, a), t)); }

/// In [0, 1).
inline Vf UnitOf(Vw h) {
  return hn::Mul(hn::ConvertTo(Floats(), hn::BitCast(Ints(), hn::ShiftRight<8>(h))), Set(1.0F / 16777216.0F));
}

inline Vw HashCell(Vw h) {
  h = hn::Xor(h, hn::ShiftRight<15>(h));
  h = hn::Mul(h, hn::Set(Words(), 0x2c1b3c6dU));
  h = hn::Xor(h, hn::ShiftRight<13>(h));
  h = hn::Mul(h, hn::Set(Words(), 0x297a2d39U));
  return hn::Xor(h, hn::ShiftRight<16>(h));
}

constexpr std::uint32_t kPrimeX = 0x8da6b343U;
constexpr std::uint32_t kPrimeY = 0xd8163841U;

/// One number in [0, 1) per cell of the lattice.
inline Vf CellValue(Vf x_floor, Vf y_floor, std::uint32_t seed) {
  const Vw x = hn::Mul(hn::BitCast(Words(), hn::ConvertTo(Ints(), x_floor)), hn::Set(Words(), kPrimeX));
  const Vw y = hn::Mul(hn::BitCast(Words(), hn::ConvertTo(Ints(), y_floor)), hn::Set(Words(), kPrimeY));
  return UnitOf(HashCell(hn::Xor(hn::Xor(x, y), hn::Set(Words(), seed))));
}

/// Smooth value noise in [-1, 1].
inline Vf Noise(Vf x, Vf y, std::uint32_t seed) {
  const Vf x_floor = hn::Floor(x);
  const Vf y_floor = hn::Floor(y);
  const Vf tx = hn::Sub(x, x_floor);
  const Vf ty = hn::Sub(y, y_floor);
  const Vf sx = hn::Mul(hn::Mul(tx, tx), hn::Sub(Set(3.0F), hn::Add(tx, tx)));
  const Vf sy = hn::Mul(hn::Mul(ty, ty), hn::Sub(Set(3.0F), hn::Add(ty, ty)));
  const Vw x0 = hn::Mul(hn::BitCast(Words(), hn::ConvertTo(Ints(), x_floor)), hn::Set(Words(), kPrimeX));
  const Vw y0 =
      hn::Xor(hn::Mul(hn::BitCast(Words(), hn::ConvertTo(Ints(), y_floor)), hn::Set(Words(), kPrimeY)),
              hn::Set(Words(), seed));
  const Vw x1 = hn::Add(x0, hn::Set(Words(), kPrimeX));
  const Vw y1 = hn::Xor(hn::Add(hn::Xor(y0, hn::Set(Words(), seed)), hn::Set(Words(), kPrimeY)),
                        hn::Set(Words(), seed));
  const Vf v00 = UnitOf(HashCell(hn::Xor(x0, y0)));
  const Vf v10 = UnitOf(HashCell(hn::Xor(x1, y0)));
  const Vf v01 = UnitOf(HashCell(hn::Xor(x0, y1)));
  const Vf v11 = UnitOf(HashCell(hn::Xor(x1, y1)));
  const Vf value = Mix(Mix(v00, v10, sx), Mix(v01, v11, sx), sy);
  return hn::Sub(hn::Add(value, value), Set(1.0F));
}

/// What is left of detail with `frequency` lattice cells a metre in a pixel of this size.
inline Vf Fade(float frequency, Vf footprint) {
  const Vf cells = hn::Mul(footprint, Set(frequency));
  return Clamp01(hn::Mul(hn::Sub(Set(kFadeEnd), cells), Set(1.0F / (kFadeEnd - kFadeStart))));
}

/// Share of a pixel of size `footprint` beyond an edge that lies `distance` inside it.
inline Vf Beyond(Vf distance, Vf footprint) {
  return Clamp01(hn::Add(hn::Div(distance, hn::Max(footprint, Set(1e-5F))), Set(0.5F)));
}

struct Point {
  Vf u, v, footprint;
  float min_footprint;  ///< over the whole run: where the octaves may stop
};

/// Noise of octaves from `coarsest` cells a metre on; standard deviation about 1 seen close.
/// @param gain  amplitude of an octave over that of the one before
Vf Fractal(const Point& p, std::uint32_t seed, float coarsest, float gain) {
  // Every octave is turned against the one before: value noise has axes, a sum of turned ones has not.
  float cosine = 0.8F;
  float sine = 0.6F;
  Vf sum = Set(0.0F);
  float amplitude = 1.0F;
  float power = 0.0F;
  for (float f = coarsest; f < kFinest; f *= kLacunarity) {
    if (f * p.min_footprint < kFadeEnd) {
      const Vf x = hn::Sub(hn::Mul(p.u, Set(f * cosine)), hn::Mul(p.v, Set(f * sine)));
      const Vf y = hn::Add(hn::Mul(p.u, Set(f * sine)), hn::Mul(p.v, Set(f * cosine)));
      const Vf octave = hn::Mul(Noise(x, y, seed), Fade(f, p.footprint));
      sum = hn::Add(sum, hn::Mul(octave, Set(amplitude)));
    }
    power += amplitude * amplitude;
    amplitude *= gain;
    seed = Hash(seed);
    const float next_cosine = 0.28F * cosine - 0.96F * sine;
    sine = 0.96F * cosine + 0.28F * sine;
    cosine = next_cosine;
  }
  return hn::Mul(sum, Set(1.0F / (kNoiseSigma * std::sqrt(power))));
}

/// Distance to the nearest line of a grid with cells of size one, and the cell.
struct GridCell {
  Vf index_u, index_v;  ///< whole numbers
  Vf edge;              ///< distance to the cell's edge, in the unit of the grid
};
inline GridCell CellOf(Vf x, Vf y) {
  GridCell cell{hn::Floor(x), hn::Floor(y), Set(0.0F)};
  const Vf fx = hn::Sub(x, cell.index_u);
  const Vf fy = hn::Sub(y, cell.index_v);
  cell.edge = hn::Min(hn::Min(fx, hn::Sub(Set(1.0F), fx)), hn::Min(fy, hn::Sub(Set(1.0F), fy)));
  return cell;
}

/// 1 in every second square, filtered: the product of two filtered square waves.
inline Vf SquareWave(Vf x, Vf width) {
  // Distance to the nearest edge, positive inside the half period that counts.
  const Vf phase = hn::Sub(x, hn::Floor(x));
  const Vf inside = hn::Sub(Set(0.25F), hn::Abs(hn::Sub(phase, Set(0.5F))));
  const Vf wave = Beyond(inside, width);
  // Once a pixel is as wide as a bar only the mean is left.
  const Vf left = Clamp01(hn::Sub(Set(2.0F), hn::Mul(width, Set(2.0F))));
  return hn::Mul(hn::Sub(hn::Add(wave, wave), Set(1.0F)), left);
}

// Each gives the departure from the mean brightness, in units of the mean.

Vf Concrete(const Point& p, std::uint32_t seed, float /*scale*/) {
  const Vf body = hn::Mul(Fractal(p, seed, 1.3F, 0.92F), Set(0.17F));
  // Pits: the peaks of two noises at once, turned against each other, which leaves no axis to see.
  constexpr float kPits = 70.0F;
  const auto peaks = [&](float cosine, float sine, std::uint32_t of) {
    const Vf x = hn::Sub(hn::Mul(p.u, Set(kPits * cosine)), hn::Mul(p.v, Set(kPits * sine)));
    const Vf y = hn::Add(hn::Mul(p.u, Set(kPits * sine)), hn::Mul(p.v, Set(kPits * cosine)));
    return Noise(x, y, Hash(seed, of));
  };
  const Vf pits = hn::Sub(hn::Add(peaks(0.8F, 0.6F, 7), peaks(0.28F, 0.96F, 8)), Set(0.75F));
  const Vf pit = hn::Mul(hn::Mul(hn::Max(pits, Set(0.0F)), Fade(kPits, p.footprint)), Set(-0.8F));
  return hn::Add(body, pit);
}

Vf Tiles(const Point& p, std::uint32_t seed, float scale) {
  const GridCell cell = CellOf(hn::Mul(p.u, Set(1.0F / scale)), hn::Mul(p.v, Set(1.0F / scale)));
  const Vf tone = hn::Mul(hn::Sub(CellValue(cell.index_u, cell.index_v, seed), Set(0.5F)), Set(0.35F));
  // Every second tile is darker; (i + j) / 2 has a fraction of a half there.
  const Vf half = hn::Mul(hn::Add(cell.index_u, cell.index_v), Set(0.5F));
  const Vf odd = hn::Sub(half, hn::Floor(half));
  const Vf checker = hn::Sub(Set(0.15F), hn::Mul(odd, Set(0.6F)));
  const Vf grain = hn::Mul(Fractal(p, Hash(seed, 1), 2.1F, 0.9F), Set(0.15F));
  // Veins: the zero lines of a slow noise.
  const Vf n = Noise(hn::Mul(p.u, Set(5.3F)), hn::Mul(p.v, Set(5.3F)), Hash(seed, 2));
  const Vf wobble =
      hn::Mul(Noise(hn::Mul(p.u, Set(31.0F)), hn::Mul(p.v, Set(31.0F)), Hash(seed, 3)), Set(0.25F));
  const Vf vein = hn::Max(hn::Sub(Set(0.08F), hn::Abs(hn::Add(n, wobble))), Set(0.0F));
  const Vf veins = hn::Mul(hn::Mul(vein, Set(2.2F)), Fade(60.0F, p.footprint));
  const Vf face = hn::Add(hn::Add(checker, tone), hn::Add(grain, veins));
  const Vf inside = Beyond(hn::Sub(hn::Mul(cell.edge, Set(scale)), Set(0.0025F)), p.footprint);
  return Mix(hn::Add(Set(-0.5F), hn::Mul(grain, Set(0.5F))), face, inside);
}

Vf Wood(const Point& p, std::uint32_t seed, float scale) {
  const Vf row = hn::Floor(hn::Mul(p.v, Set(1.0F / scale)));
  const Vf shift = hn::Mul(CellValue(row, Set(3.0F), seed), Set(7.0F));
  const Vf along = hn::Mul(hn::Add(p.u, shift), Set(1.0F / (8.0F * scale)));
  const Vf fv = hn::Sub(hn::Mul(p.v, Set(1.0F / scale)), row);
  const Vf plank = hn::Floor(along);
  const Vf tone = hn::Mul(hn::Sub(CellValue(plank, row, Hash(seed, 1)), Set(0.5F)), Set(0.45F));
  // Grain: noise drawn out twelve times along the plank, and some that is not.
  Point drawn = p;
  drawn.u = hn::Mul(hn::Add(p.u, hn::Mul(shift, Set(3.0F))), Set(1.0F / 12.0F));
  const Vf grain = hn::Mul(Fractal(drawn, Hash(seed, 2), 9.0F, 0.88F), Set(0.16F));
  const Vf fine = hn::Mul(Fractal(p, Hash(seed, 4), 11.0F, 0.9F), Set(0.06F));
  const Vf seam = hn::Sub(hn::Mul(hn::Min(fv, hn::Sub(Set(1.0F), fv)), Set(scale)), Set(0.0015F));
  return Mix(Set(-0.6F), hn::Add(tone, hn::Add(grain, fine)), Beyond(seam, p.footprint));
}

Vf Brick(const Point& p, std::uint32_t seed, float scale) {
  const Vf y = hn::Mul(p.v, Set(1.0F / scale));
  const Vf row = hn::Floor(y);
  const Vf half = hn::Mul(row, Set(0.5F));
  const Vf shift = hn::Sub(half, hn::Floor(half));
  const float length = 3.1F * scale;
  const Vf x = hn::Add(hn::Mul(p.u, Set(1.0F / length)), shift);
  const Vf column = hn::Floor(x);
  const Vf fx = hn::Sub(x, column);
  const Vf fy = hn::Sub(y, row);
  const Vf edge = hn::Min(hn::Mul(hn::Min(fx, hn::Sub(Set(1.0F), fx)), Set(length)),
                          hn::Mul(hn::Min(fy, hn::Sub(Set(1.0F), fy)), Set(scale)));
  const Vf tone = hn::Mul(hn::Sub(CellValue(column, row, seed), Set(0.5F)), Set(0.5F));
  const Vf grain = hn::Mul(Fractal(p, Hash(seed, 1), 3.0F, 0.92F), Set(0.14F));
  return hn::Add(Mix(Set(0.35F), hn::Sub(tone, Set(0.1F)), Beyond(hn::Sub(edge, Set(0.005F)), p.footprint)),
                 grain);
}

Vf Checker(const Point& p, std::uint32_t seed, float scale) {
  const Vf width = hn::Mul(p.footprint, Set(0.5F / scale));
  const Vf a = SquareWave(hn::Mul(p.u, Set(0.5F / scale)), width);
  const Vf b = SquareWave(hn::Mul(p.v, Set(0.5F / scale)), width);
  return hn::Add(hn::Mul(hn::Mul(a, b), Set(0.6F)), hn::Mul(Fractal(p, seed, 2.3F, 0.9F), Set(0.08F)));
}

Vf Posters(const Point& p, std::uint32_t seed, float scale) {
  const Vf x = hn::Mul(p.u, Set(1.0F / scale));
  const Vf y = hn::Mul(p.v, Set(1.0F / scale));
  const GridCell cell = CellOf(x, y);
  const Vf pick = CellValue(cell.index_u, cell.index_v, seed);
  // Lines of words: cells of 3 cm by 4 cm within the poster, most of them ink.
  const GridCell word = CellOf(hn::Mul(p.u, Set(1.0F / 0.03F)), hn::Mul(p.v, Set(1.0F / 0.04F)));
  const Vf ink = CellValue(word.index_u, word.index_v, Hash(seed, 1));
  const Vf letter_ink = CellValue(hn::Floor(hn::Mul(p.u, Set(1.0F / 0.007F))), word.index_v, Hash(seed, 2));
  const Vf line = hn::Sub(hn::Mul(p.v, Set(1.0F / 0.04F)), word.index_v);
  const Vf in_line = hn::Sub(Set(0.3F), hn::Abs(hn::Sub(line, Set(0.5F))));
  const Vf dark =
      hn::IfThenElse(hn::Gt(ink, Set(0.3F)),
                     hn::IfThenElse(hn::Gt(letter_ink, Set(0.35F)), Set(-1.1F), Set(0.0F)), Set(0.0F));
  const Vf text =
      hn::Mul(hn::Mul(dark, Beyond(hn::Mul(in_line, Set(0.04F)), p.footprint)), Fade(90.0F, p.footprint));
  const Vf paper = hn::Add(hn::Sub(hn::Mul(pick, Set(1.6F)), Set(0.35F)), text);
  const Vf plain = hn::Mul(Fractal(p, Hash(seed, 3), 1.7F, 0.9F), Set(0.035F));
  const Vf margin = hn::Mul(hn::Sub(cell.edge, Set(0.18F)), Set(scale));
  const Vf there = hn::IfThenElse(hn::Gt(pick, Set(0.4F)), Beyond(margin, p.footprint), Set(0.0F));
  return Mix(plain, hn::Add(paper, plain), there);
}

Vf Grating(const Point& p, std::uint32_t seed, float scale) {
  const Vf bars = SquareWave(hn::Mul(p.u, Set(1.0F / scale)), hn::Mul(p.footprint, Set(1.0F / scale)));
  return hn::Add(hn::Mul(bars, Set(0.6F)), hn::Mul(Fractal(p, seed, 3.0F, 0.9F), Set(0.03F)));
}

void Evaluate(const Material& material, std::uint32_t seed, const float* u, const float* v,
              const float* footprint, int n, float* albedo) {
  const Floats d;
  const float scale = static_cast<float>(material.scale_m);
  const Vf mean = Set(static_cast<float>(material.albedo));
  const Vf contrast = Set(static_cast<float>(material.contrast));
  const float min_footprint = *std::min_element(footprint, footprint + n);
  for (int i = 0; i < n; i += static_cast<int>(hn::Lanes(d))) {
    const Point p{hn::LoadU(d, u + i), hn::LoadU(d, v + i), hn::LoadU(d, footprint + i), min_footprint};
    Vf tone = Set(0.0F);
    switch (material.pattern) {
      case Pattern::kPlain:
        tone = hn::Mul(Fractal(p, seed, 1.7F, 0.9F), Set(0.03F));
        break;
      case Pattern::kNoise:
        tone = hn::Mul(Fractal(p, seed, 2.5F, 0.95F), Set(0.32F));
        break;
      case Pattern::kConcrete:
        tone = Concrete(p, seed, scale);
        break;
      case Pattern::kTiles:
        tone = Tiles(p, seed, scale);
        break;
      case Pattern::kWood:
        tone = Wood(p, seed, scale);
        break;
      case Pattern::kBrick:
        tone = Brick(p, seed, scale);
        break;
      case Pattern::kChecker:
        tone = Checker(p, seed, scale);
        break;
      case Pattern::kPosters:
        tone = Posters(p, seed, scale);
        break;
      case Pattern::kGrating:
        tone = Grating(p, seed, scale);
        break;
    }
    const Vf value = hn::Mul(mean, hn::Add(Set(1.0F), hn::Mul(tone, contrast)));
    hn::StoreU(hn::Min(hn::Max(value, Set(0.015F)), Set(0.95F)), d, albedo + i);
  }
}

}  // namespace terrace::synthetic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace::synthetic {
HWY_EXPORT(Evaluate);

void EvaluateTexture(const Material& material, std::uint32_t seed, const float* u_m, const float* v_m,
                     const float* footprint_m, int n, float* albedo) {
  HWY_DYNAMIC_DISPATCH(Evaluate)(material, Hash(seed, material.seed), u_m, v_m, footprint_m, n, albedo);
}

}  // namespace terrace::synthetic
#endif
