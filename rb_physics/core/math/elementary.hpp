// Sine, cosine and arctangent from + - * / and sqrt only. glibc picks FMA variants by CPU, so the
// same binary would give other bits on another machine; these give the same bits everywhere.
#pragma once

namespace rb {

inline constexpr double pi = 3.14159265358979323846;

struct SinCos {
  double sin;
  double cos;
};

// x in rad. Error below 1 ulp for |x| <= 1e5; beyond it the reduction error grows as |x| * 1e-16.
SinCos sin_cos(double x);
double sin(double x);
double cos(double x);

// Angle of the vector (x, y) in (-pi, pi]; atan2(0, 0) = 0. Error below 4e-16.
double atan2(double y, double x);
double acos(double x);  // x in [-1, 1]; values outside by rounding are taken as +-1
double asin(double x);

}  // namespace rb
