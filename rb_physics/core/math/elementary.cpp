#include "math/elementary.hpp"

#include <cmath>

namespace rb {
namespace {

// pi/2 in three parts of 33 bits or fewer, so that k * part is exact for |k| < 2^20.
constexpr double half_pi_1 = 1.57079632673412561417e+00;
constexpr double half_pi_2 = 6.07710050630396597660e-11;
constexpr double half_pi_3 = 2.02226624879595063154e-21;

// Taylor polynomials on [-pi/4, pi/4]: the first neglected terms are below 1e-19.
double sin_kernel(double x) {
  const double z = x * x;
  double s = -1.0 / 121645100408832000.0;
  s = 1.0 / 355687428096000.0 + z * s;
  s = -1.0 / 1307674368000.0 + z * s;
  s = 1.0 / 6227020800.0 + z * s;
  s = -1.0 / 39916800.0 + z * s;
  s = 1.0 / 362880.0 + z * s;
  s = -1.0 / 5040.0 + z * s;
  s = 1.0 / 120.0 + z * s;
  s = -1.0 / 6.0 + z * s;
  return x + x * z * s;
}

double cos_kernel(double x) {
  const double z = x * x;
  double c = 1.0 / 2432902008176640000.0;
  c = -1.0 / 6402373705728000.0 + z * c;
  c = 1.0 / 20922789888000.0 + z * c;
  c = -1.0 / 87178291200.0 + z * c;
  c = 1.0 / 479001600.0 + z * c;
  c = -1.0 / 3628800.0 + z * c;
  c = 1.0 / 40320.0 + z * c;
  c = -1.0 / 720.0 + z * c;
  c = 1.0 / 24.0 + z * c;
  const double half = 0.5 * z;
  const double w = 1.0 - half;
  return w + (((1.0 - w) - half) + z * z * c);
}

// atan on [0, tan(pi/16)]: alternating series, first neglected term below 1e-19.
double atan_kernel(double x) {
  const double z = x * x;
  double s = 0.0;
  for (int n = 25; n >= 3; n -= 2) s = z * ((((n - 1) / 2) % 2 ? -1.0 : 1.0) / n + s);
  return x + x * s;
}

// atan(x) for x in [0, 1]: angle halving atan(x) = 2 atan(x / (1 + sqrt(1 + x^2))).
double atan_unit(double x) {
  double scale = 1.0;
  while (x > 0.198) {
    x = x / (1.0 + std::sqrt(1.0 + x * x));
    scale *= 2.0;
  }
  return scale * atan_kernel(x);
}

}  // namespace

SinCos sin_cos(double x) {
  const double k = std::floor(x * (2.0 / pi) + 0.5);
  const double r = ((x - k * half_pi_1) - k * half_pi_2) - k * half_pi_3;
  const double s = sin_kernel(r);
  const double c = cos_kernel(r);
  const double quadrant = k - 4.0 * std::floor(k * 0.25);
  if (quadrant == 0.0) return {s, c};
  if (quadrant == 1.0) return {c, -s};
  if (quadrant == 2.0) return {-s, -c};
  return {-c, s};
}

double sin(double x) { return sin_cos(x).sin; }
double cos(double x) { return sin_cos(x).cos; }

double atan2(double y, double x) {
  const double ax = std::fabs(x);
  const double ay = std::fabs(y);
  if (ax == 0.0 && ay == 0.0) return 0.0;
  double angle = ay <= ax ? atan_unit(ay / ax) : 0.5 * pi - atan_unit(ax / ay);
  if (x < 0.0) angle = pi - angle;
  return y < 0.0 ? -angle : angle;
}

double acos(double x) {
  if (x > 1.0) x = 1.0;
  if (x < -1.0) x = -1.0;
  return atan2(std::sqrt((1.0 - x) * (1.0 + x)), x);
}

double asin(double x) {
  if (x > 1.0) x = 1.0;
  if (x < -1.0) x = -1.0;
  return atan2(x, std::sqrt((1.0 - x) * (1.0 + x)));
}

}  // namespace rb
