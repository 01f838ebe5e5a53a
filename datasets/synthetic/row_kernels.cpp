// SPDX-License-Identifier: BSD-3-Clause
#include "datasets/synthetic/row_kernels.h"

#define HWY_DISABLED_TARGETS (HWY_SSSE3 | HWY_AVX3 | HWY_AVX3_DL)
#undef HWY_TARGET_INCLUDE
#define HWY_TARGET_INCLUDE "datasets/synthetic/row_kernels.cpp"
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

inline Vf Set(float value) { return hn::Set(Floats(), value); }
inline Vf ScaleAdd(Vf a, Vf b, Vf c) {
  return hn::Add(hn::Mul(a, b), c);
}  // rounded twice, on every processor
inline Vf Dot(const float* a, Vf x, Vf y, Vf z) {
  return hn::Add(hn::Mul(x, Set(a[0])), hn::Add(hn::Mul(y, Set(a[1])), hn::Mul(z, Set(a[2]))));
}

inline Vw HashPixels(Vw h) {
  h = hn::Xor(h, hn::ShiftRight<16>(h));
  h = hn::Mul(h, hn::Set(Words(), 0x7feb352dU));
  h = hn::Xor(h, hn::ShiftRight<15>(h));
  h = hn::Mul(h, hn::Set(Words(), 0x846ca68bU));
  return hn::Xor(h, hn::ShiftRight<16>(h));
}

void Generate(const RowRays& r, float* dx, float* dy, float* dz) {
  const Floats d;
  const Ints di;
  const int lanes = static_cast<int>(hn::Lanes(d));
  for (int x = 0; x < r.width; x += lanes) {
    const Vi column = hn::Iota(di, x);
    Vf du = Set(0.0F);
    Vf dv = Set(0.0F);
    if (r.jitter) {
      const Vw h =
          HashPixels(hn::Xor(hn::BitCast(Words(), column),
                             hn::Set(Words(), r.seed + 0x9e3779b9U * static_cast<std::uint32_t>(r.row))));
      // Digits of both coordinates are turned over (xor): each pixel has samples of its own that fill it as
      // evenly.
      const Vw again = HashPixels(hn::Add(h, hn::Set(Words(), 0x9e3779b9U)));
      const Vw su = hn::Xor(h, hn::Set(Words(), r.sample_u));
      const Vw sv = hn::Xor(again, hn::Set(Words(), r.sample_v));
      const Vf unit = Set(1.0F / 16777216.0F);
      du = hn::Sub(hn::Mul(hn::ConvertTo(d, hn::BitCast(di, hn::ShiftRight<8>(su))), unit), Set(0.5F));
      dv = hn::Sub(hn::Mul(hn::ConvertTo(d, hn::BitCast(di, hn::ShiftRight<8>(sv))), unit), Set(0.5F));
    }
    const Vf u = hn::Add(hn::ConvertTo(d, column), du);
    const Vf v = hn::Add(Set(static_cast<float>(r.row)), dv);
    hn::StoreU(ScaleAdd(Set(r.across[0]), u, ScaleAdd(Set(r.down[0]), v, Set(r.base[0]))), d, dx + x);
    hn::StoreU(ScaleAdd(Set(r.across[1]), u, ScaleAdd(Set(r.down[1]), v, Set(r.base[1]))), d, dy + x);
    hn::StoreU(ScaleAdd(Set(r.across[2]), u, ScaleAdd(Set(r.down[2]), v, Set(r.base[2]))), d, dz + x);
  }
}

void Meet(const PlaneView& p, const float* dx, const float* dy, const float* dz, int n, float* u, float* v,
          float* footprint, float* depth) {
  const Floats d;
  for (int i = 0; i < n; i += static_cast<int>(hn::Lanes(d))) {
    const Vf x = hn::LoadU(d, dx + i);
    const Vf y = hn::LoadU(d, dy + i);
    const Vf z = hn::LoadU(d, dz + i);
    const Vf slope = Dot(p.normal, x, y, z);
    const Vf t = hn::Div(Set(p.distance), slope);
    hn::StoreU(t, d, depth + i);
    hn::StoreU(ScaleAdd(t, Dot(p.axis_u, x, y, z), Set(p.origin_u)), d, u + i);
    hn::StoreU(ScaleAdd(t, Dot(p.axis_v, x, y, z), Set(p.origin_v)), d, v + i);
    // A pixel covers t^2 / (fx fy |n . d|) of the plane.
    const Vf root = hn::Sqrt(hn::Max(hn::Abs(slope), Set(1e-6F)));
    hn::StoreU(hn::Div(hn::Mul(t, Set(p.inverse_focal)), root), d, footprint + i);
  }
}

void Light(const LightGrid& g, const float* u, const float* v, const float* albedo, int n, float weight,
           float* radiance) {
  const Floats d;
  const Ints di;
  const Vf last_u = Set(static_cast<float>(g.nu - 2));
  const Vf last_v = Set(static_cast<float>(g.nv - 2));
  for (int i = 0; i < n; i += static_cast<int>(hn::Lanes(d))) {
    const Vf x = hn::Mul(hn::Sub(hn::LoadU(d, u + i), Set(g.u0)), Set(g.per_texel));
    const Vf y = hn::Mul(hn::Sub(hn::LoadU(d, v + i), Set(g.v0)), Set(g.per_texel));
    const Vf xi = hn::Min(hn::Max(hn::Floor(x), Set(0.0F)), last_u);
    const Vf yi = hn::Min(hn::Max(hn::Floor(y), Set(0.0F)), last_v);
    const Vf tx = hn::Min(hn::Max(hn::Sub(x, xi), Set(0.0F)), Set(1.0F));
    const Vf ty = hn::Min(hn::Max(hn::Sub(y, yi), Set(0.0F)), Set(1.0F));
    // What lies beyond n may be no number; its index must stay inside all the same.
    const Vi raw = hn::Add(hn::Mul(hn::ConvertTo(di, yi), hn::Set(di, g.nu)), hn::ConvertTo(di, xi));
    const Vi index = hn::Min(hn::Max(raw, hn::Zero(di)), hn::Set(di, g.nu * (g.nv - 1) - 2));
    const Vf v00 = hn::GatherIndex(d, g.values, index);
    const Vf v10 = hn::GatherIndex(d, g.values + 1, index);
    const Vf v01 = hn::GatherIndex(d, g.values + g.nu, index);
    const Vf v11 = hn::GatherIndex(d, g.values + g.nu + 1, index);
    const Vf low = ScaleAdd(hn::Sub(v10, v00), tx, v00);
    const Vf high = ScaleAdd(hn::Sub(v11, v01), tx, v01);
    const Vf light = ScaleAdd(hn::Sub(high, low), ty, low);
    const Vf sum =
        ScaleAdd(hn::Mul(light, hn::LoadU(d, albedo + i)), Set(weight), hn::LoadU(d, radiance + i));
    // Only n of them: the run behind this one has its own light.
    if (i + static_cast<int>(hn::Lanes(d)) <= n) {
      hn::StoreU(sum, d, radiance + i);
    } else {
      HWY_ALIGN float rest[hn::MaxLanes(d)];
      hn::Store(sum, d, rest);
      for (int k = i; k < n; ++k) radiance[k] = rest[k - i];
    }
  }
}

}  // namespace terrace::synthetic::HWY_NAMESPACE
HWY_AFTER_NAMESPACE();

#if HWY_ONCE
namespace terrace::synthetic {
HWY_EXPORT(Generate);
HWY_EXPORT(Meet);
HWY_EXPORT(Light);

void GenerateRays(const RowRays& rays, float* dx, float* dy, float* dz) {
  HWY_DYNAMIC_DISPATCH(Generate)(rays, dx, dy, dz);
}

void MeetPlane(const PlaneView& plane, const float* dx, const float* dy, const float* dz, int n, float* u_m,
               float* v_m, float* footprint_m, float* depth_m) {
  HWY_DYNAMIC_DISPATCH(Meet)(plane, dx, dy, dz, n, u_m, v_m, footprint_m, depth_m);
}

void AddLit(const LightGrid& grid, const float* u_m, const float* v_m, const float* albedo, int n,
            float weight, float* radiance) {
  HWY_DYNAMIC_DISPATCH(Light)(grid, u_m, v_m, albedo, n, weight, radiance);
}

}  // namespace terrace::synthetic
#endif
