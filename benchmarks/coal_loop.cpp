// Times coal::collide in a C++ loop, so that Python's cost of a call stays out of the comparison.
// stdin: two shapes (sphere r | capsule r h | cylinder r h | box x y z | hull n x y z ...), margin,
// number of poses, then per pose position and quaternion (x y z w) of A and of B. stdout: ns per
// query.
#include <coal/collision.h>
#include <coal/shape/convex.h>
#include <coal/shape/geometric_shapes.h>

#include <algorithm>
#include <chrono>
#include <iostream>
#include <memory>
#include <string>
#include <vector>

namespace {

std::shared_ptr<coal::CollisionGeometry> read_shape() {
  std::string name;
  std::cin >> name;
  double x, y, z;
  if (name == "sphere") {
    std::cin >> x;
    return std::make_shared<coal::Sphere>(x);
  }
  if (name == "capsule") {
    std::cin >> x >> y;
    return std::make_shared<coal::Capsule>(x, 2 * y);
  }
  if (name == "cylinder") {
    std::cin >> x >> y;
    return std::make_shared<coal::Cylinder>(x, 2 * y);
  }
  if (name == "box") {
    std::cin >> x >> y >> z;
    return std::make_shared<coal::Box>(2 * x, 2 * y, 2 * z);
  }
  int n;
  std::cin >> n;
  auto points = std::make_shared<std::vector<coal::Vec3s>>(n);
  for (auto& p : *points) std::cin >> p[0] >> p[1] >> p[2];
  return std::shared_ptr<coal::CollisionGeometry>(
      coal::ConvexBase::convexHull(points, static_cast<unsigned>(n), true, "Qt"));
}

coal::Transform3s read_pose() {
  double p[7];
  for (double& v : p) std::cin >> v;
  return coal::Transform3s(Eigen::Quaternion<double>(p[6], p[3], p[4], p[5]),
                           coal::Vec3s(p[0], p[1], p[2]));
}

}  // namespace

int main() {
  const auto a = read_shape(), b = read_shape();
  coal::CollisionRequest request;
  int n;
  std::cin >> request.security_margin >> n;
  request.enable_contact = true;
  std::vector<std::pair<coal::Transform3s, coal::Transform3s>> poses;
  for (int i = 0; i < n; ++i) {
    const coal::Transform3s first = read_pose();
    poses.emplace_back(first, read_pose());
  }
  coal::CollisionResult result;
  double best = 1e300;
  for (int repeat = 0; repeat < 5; ++repeat) {
    const auto start = std::chrono::steady_clock::now();
    for (const auto& [pose_a, pose_b] : poses) {
      result.clear();
      coal::collide(a.get(), pose_a, b.get(), pose_b, request, result);
    }
    const std::chrono::duration<double, std::nano> taken = std::chrono::steady_clock::now() - start;
    best = std::min(best, taken.count());
  }
  std::cout << best / n << std::endl;
}
