#include "libmpm/material/hencky_elastic.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>
#include <fstream>
#include <string>

#include "libmpm/base/error.hpp"

namespace {

using namespace mpm;

TEST(HenckyElastic, SimpleShearMatchesTheExactSolution) {
  std::ifstream file(MPM_SOURCE_DIR "/reference_data/hencky_simple_shear/data.csv");
  ASSERT_TRUE(file);
  std::string line;
  std::getline(file, line), std::getline(file, line);
  const HenckyElastic law(HenckyElastic::Parameters{});  // E = 1 MPa, nu = 0.1, as in the table
  int read = 0;
  double gamma = 0.0, tau12 = 0.0, tau11 = 0.0, tau22 = 0.0, q = 0.0;
  while (std::getline(file, line) && std::sscanf(line.c_str(), "%lf,%lf,%lf,%lf,%lf", &gamma, &tau12, &tau11, &tau22, &q) == 5) {
    ++read;
    for (const int steps : {1, 10, 1000}) {
      MaterialState<double> s{};
      Matrix3<double> dl{};
      dl.m[0][1] = gamma / steps;
      for (int i = 0; i < steps; ++i) law.update_stress(s, dl, 1.0);
      // The table's 12 digits; each step adds round-off of about 1e-16 of G.
      const double tolerance = 2e-12 * 1e3 * q + 1e-15 * steps * law.moduli().shear();
      EXPECT_NEAR(s.stress.xy, 1e3 * tau12, tolerance) << gamma << " in " << steps;
      EXPECT_NEAR(s.stress.xx, 1e3 * tau11, tolerance) << gamma << " in " << steps;
      EXPECT_NEAR(s.stress.yy, 1e3 * tau22, tolerance) << gamma << " in " << steps;
      EXPECT_NEAR(s.stress.zz, 0.0, tolerance);
    }
  }
  EXPECT_EQ(read, 7);
}

TEST(HenckyElastic, ReturnsToTheReferenceStateOnAClosedPath) {
  const HenckyElastic law(HenckyElastic::Parameters{});
  MaterialState<double> s{};
  Matrix3<double> there{}, back{};
  there.m[0][1] = 0.3, back.m[0][1] = -0.3;
  law.update_stress(s, there, 1.0);
  law.update_stress(s, back, 1.0);
  EXPECT_LE(std::sqrt(norm2(s.stress)), 1e-13 * law.moduli().shear() * 0.3);  // round-off of strains of 0.3
}

TEST(HenckyElastic, WaveSpeedOfThePapersSnow) {
  // physics: 58.4 m/s at E = 1 MPa, nu = 0.1, 300 kg/m^3; exactly sqrt(E (1 - nu) / ((1 + nu)(1 - 2 nu) rho))
  const HenckyElastic law(HenckyElastic::Parameters{});
  EXPECT_NEAR(law.wave_speed(), std::sqrt(1e6 * 0.9 / (1.1 * 0.8 * 300.0)), 1e-11);
  EXPECT_NEAR(law.wave_speed(), 58.4, 0.05);
}

TEST(HenckyElastic, RefusesNonsense) {
  for (const auto& change :
       {+[](HenckyElastic::Parameters& s) { s.young_modulus = 0.0; }, +[](HenckyElastic::Parameters& s) { s.young_modulus = std::nan(""); },
        +[](HenckyElastic::Parameters& s) { s.poisson_ratio = 0.5; }, +[](HenckyElastic::Parameters& s) { s.poisson_ratio = -1.0; },
        +[](HenckyElastic::Parameters& s) { s.density = -1.0; }}) {
    HenckyElastic::Parameters spec;
    change(spec);
    EXPECT_THROW(HenckyElastic{spec}, ConfigError);
  }
}

}  // namespace
