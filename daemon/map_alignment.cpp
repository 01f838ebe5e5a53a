// SPDX-License-Identifier: BSD-3-Clause
#include "daemon/map_alignment.h"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <memory>
#include <utility>

#include "client/inset.h"
#include "client/region_shape.h"
#include "core/print.h"

namespace terrace {
namespace {

constexpr double kMaxFacesApart_rad = 10.0 * M_PI / 180.0;
constexpr double kMinCommon_m2 = 0.03;
constexpr int kMaxSteps = 6;
// Of maps that were made twice, beyond what their planes' covariances say.
constexpr double kMapNoise_m = 0.007;
constexpr double kMapNoise_rad = 0.3 * M_PI / 180.0;
// Planes further apart than this are other surfaces, or the map has changed.
constexpr double kSameWithin_m = 0.03;
constexpr double kSearch_m = 0.3;
// So exact must the place be at the robot before what is seen is said to confirm it.
constexpr double kConfirmed_m = 0.03;
constexpr double kConfirmed_rad = 1.0 * M_PI / 180.0;
constexpr double kConfirmedShare = 0.8;
// Further from the prior, in squares of sigmas, than 99.9 % of what it allows: one of both is wrong.
constexpr double kMaxSquares = 22.46;  // chi squared of six numbers

struct Face {
  const TerrainRegion* region = nullptr;
  std::shared_ptr<const RegionShape> shape;
};

/// Two planes that should be one: z + H * error = noise, for the gap and the two tilts.
struct Pair {
  Eigen::Matrix<double, 3, 6> H = Eigen::Matrix<double, 3, 6>::Zero();
  Eigen::Vector3d z = Eigen::Vector3d::Zero();
  Eigen::Vector3d variances = Eigen::Vector3d::Ones();
  double common_m2 = 0.0;
};

double TiltVariance(const TerrainRegion& region) {
  return std::max(region.plane_covariance(0, 0), region.plane_covariance(1, 1));
}

/// The middle of the part that both faces show, on the seen one's plane; its area.
double CommonPart(const Face& loaded, const Face& seen, Eigen::Vector3d* middle_world) {
  std::vector<FlatRing> rings;
  const auto add = [&](const Ring& ring_world) {
    FlatRing& ring = rings.emplace_back();
    for (const Eigen::Vector3d& p : ring_world) ring.push_back(loaded.shape->ToPlane(p));
  };
  add(seen.region->outline_world);
  for (const Ring& hole : seen.region->holes_world) add(hole);
  const FlatPolygon common = Within(loaded.shape->polygon(), rings);
  if (common.empty()) return 0.0;
  const Eigen::Vector3d on_loaded = loaded.shape->ToWorld(common.box().center());
  *middle_world = seen.region->plane_world.Project(on_loaded);
  return common.area_m2();
}

Pair PairOf(const Face& loaded, const Face& seen, const Eigen::Vector3d& middle_world, double common_m2) {
  const Eigen::Vector3d& normal = loaded.shape->normal_world();
  const PlaneAxes& axes = loaded.shape->axes_world();
  Pair pair;
  pair.common_m2 = common_m2;
  pair.z << normal.dot(middle_world - loaded.shape->centroid_world()),
      seen.region->plane_world.normal.dot(axes.x), seen.region->plane_world.normal.dot(axes.y);
  // An error (w, v) of the place moves the loaded plane by -(w x p + v) and turns its normal by -(w x n).
  pair.H.block<1, 3>(0, 0) = middle_world.cross(normal).transpose();
  pair.H.block<1, 3>(0, 3) = normal.transpose();
  pair.H.block<1, 3>(1, 0) = axes.y.transpose();
  pair.H.block<1, 3>(2, 0) = -axes.x.transpose();
  const auto offset_variance = [&](const Face& face) {
    const Eigen::Vector2d at = face.shape->ToPlane(middle_world);
    const Eigen::Vector3d lift(at.y(), -at.x(), 1.0);
    return lift.dot(face.region->plane_covariance * lift);
  };
  const double tilt =
      TiltVariance(*loaded.region) + TiltVariance(*seen.region) + kMapNoise_rad * kMapNoise_rad;
  pair.variances << offset_variance(loaded) + offset_variance(seen) + kMapNoise_m * kMapNoise_m, tilt, tilt;
  return pair;
}

/// What is not decided may be a slant laid over steps that are too far to be told apart: another one each
/// time.
std::vector<Face> FacesOf(const std::vector<TerrainRegion>& regions) {
  std::vector<Face> faces;
  for (const TerrainRegion& region : regions) {
    if (!IsDecided(region) || !region.plane_covariance.allFinite()) continue;
    faces.push_back({&region, std::make_shared<const RegionShape>(region)});
  }
  return faces;
}

std::vector<Pair> PairsOf(const std::vector<Face>& loaded, const std::vector<Face>& seen) {
  const Eigen::Vector3d search = Eigen::Vector3d::Constant(kSearch_m);
  std::vector<Pair> pairs;
  for (const Face& face : seen) {
    const Eigen::AlignedBox3d box(face.shape->box_world().min() - search,
                                  face.shape->box_world().max() + search);
    for (const Face& other : loaded) {
      if (!other.shape->box_world().intersects(box)) continue;
      if (face.shape->normal_world().dot(other.shape->normal_world()) < std::cos(kMaxFacesApart_rad))
        continue;
      Eigen::Vector3d middle_world = Eigen::Vector3d::Zero();
      const double common_m2 = CommonPart(other, face, &middle_world);
      if (common_m2 < kMinCommon_m2) continue;
      pairs.push_back(PairOf(other, face, middle_world, common_m2));
      if (std::abs(pairs.back().z[0]) > kSearch_m) pairs.pop_back();
    }
  }
  return pairs;
}

/// Of a pair in the fit: 0 where the gap cannot be an error of the place, 1 where gap and tilts are what is
/// expected of one, and less the further they are from that, as for errors by Student's t.
double WeightOf(const Pair& pair, const Matrix6d& covariance) {
  constexpr double kFreedom = 4.0;  // the less, the less is an unlikely pair worth
  Eigen::Matrix3d expected = pair.H * covariance * pair.H.transpose();
  expected.diagonal() += pair.variances;
  if (std::abs(pair.z[0]) > std::max(kSameWithin_m, 3.0 * std::sqrt(expected(0, 0)))) return 0.0;
  const double squares = pair.z.dot(expected.ldlt().solve(pair.z));
  return std::min(1.0, (kFreedom + 3.0) / (kFreedom + squares));
}

Eigen::Isometry3d Exp(const Vector6d& error) {
  Eigen::Isometry3d T = Eigen::Isometry3d::Identity();
  const double angle = error.head<3>().norm();
  if (angle > 0.0) T.linear() = Eigen::AngleAxisd(angle, error.head<3>() / angle).toRotationMatrix();
  T.translation() = error.tail<3>();
  return T;
}

Vector6d Log(const Eigen::Isometry3d& T) {
  const Eigen::AngleAxisd turn(T.linear());
  Vector6d error;
  error << turn.angle() * turn.axis(), T.translation();
  return error;
}

/// Sigmas at the body: rotation, then translation.
Vector6d SigmasAt(const Matrix6d& covariance, const Eigen::Vector3d& p_world) {
  Matrix6d transport = Matrix6d::Identity();
  transport.bottomLeftCorner<3, 3>() << 0.0, p_world.z(), -p_world.y(), -p_world.z(), 0.0, p_world.x(),
      p_world.y(), -p_world.x(), 0.0;
  return (transport * covariance * transport.transpose()).diagonal().cwiseMax(0.0).cwiseSqrt();
}

std::string WhyNotConfirmed(const MapAlignment& alignment, const MapPlace& prior,
                            const Eigen::Vector3d& body_world) {
  const Vector6d moved = Log(prior.T_map_world.inverse() * alignment.place.T_map_world);
  if (moved.dot(prior.covariance.ldlt().solve(moved)) > kMaxSquares)
    return Printed("what is seen lies %.2f m from where it was put",
                   (moved.tail<3>() + moved.head<3>().cross(body_world)).norm());
  const double share = alignment.agrees_m2 / std::max(1e-9, alignment.agrees_m2 + alignment.differs_m2);
  if (!(alignment.agrees_m2 > 0.0)) return "nothing that is seen is in the loaded map yet";
  if (share < kConfirmedShare)
    return Printed("only %.0f %% of what is seen agrees with the loaded map", 100.0 * share);
  const Vector6d sigma = SigmasAt(alignment.place.covariance, body_world);
  if (sigma.tail<3>().maxCoeff() > kConfirmed_m || sigma.head<3>().maxCoeff() > kConfirmed_rad)
    return Printed("too little is seen to say where along its surfaces the robot is: sigma %.3f m, %.1f deg",
                   sigma.tail<3>().maxCoeff(), sigma.head<3>().maxCoeff() * 180.0 / M_PI);
  return "";
}

}  // namespace

MapAlignment Align(const std::vector<TerrainRegion>& loaded_map, const MapPlace& prior,
                   const TerrainMap& seen, const Eigen::Vector3d& body_world) {
  std::vector<TerrainRegion> seen_regions;
  for (const auto& region : seen.regions)
    if (region->area_m2 >= kMinCommon_m2) seen_regions.push_back(*region);
  const std::vector<Face> seen_faces = FacesOf(seen_regions);
  const Matrix6d prior_information = prior.covariance.inverse();
  MapAlignment alignment;
  alignment.place = prior;
  std::vector<Pair> pairs;
  for (int step = 0; step < kMaxSteps; ++step) {
    // Where the loaded planes lie by the newest place, with their own covariances alone.
    MapPlace exact = alignment.place;
    exact.covariance.setZero();
    std::vector<TerrainRegion> placed;
    for (const TerrainRegion& region : loaded_map) placed.push_back(Placed(region, exact));
    pairs = PairsOf(FacesOf(placed), seen_faces);
    // The prior pulls back to where it was.
    const Vector6d moved = Log(prior.T_map_world.inverse() * alignment.place.T_map_world);
    // At first the prior says what can be an error of the place, then what has been found.
    const Matrix6d gate = step < 2 ? prior.covariance : alignment.place.covariance;
    Matrix6d information = prior_information;
    Vector6d pull = -prior_information * moved;
    for (const Pair& pair : pairs) {
      const double weight = WeightOf(pair, gate);
      if (weight == 0.0) continue;
      const Eigen::Matrix<double, 6, 3> weighted =
          weight * pair.H.transpose() * pair.variances.cwiseInverse().asDiagonal();
      information += weighted * pair.H;
      pull -= weighted * pair.z;
    }
    const Vector6d error = information.ldlt().solve(pull);
    alignment.place.T_map_world = alignment.place.T_map_world * Exp(error);
    alignment.place.covariance = information.inverse();
    if (error.norm() < 1e-6) break;
  }
  for (const Pair& pair : pairs)
    (std::abs(pair.z[0]) <= kSameWithin_m ? alignment.agrees_m2 : alignment.differs_m2) += pair.common_m2;
  alignment.reason = WhyNotConfirmed(alignment, prior, body_world);
  alignment.confirmed = alignment.reason.empty();
  return alignment;
}

}  // namespace terrace
