// What every law has to satisfy.

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <random>
#include <string>

#include "libmpm/base/error.hpp"
#include "libmpm/base/parameter.hpp"
#include "libmpm/material/any_material.hpp"
#include "support/typical_materials.hpp"

namespace {

using namespace mpm;

using Entry = MaterialParameters;
constexpr double strain_in_step = 0.02;  // large enough that every law does all it can

class Random {
 public:
  double operator()() { return uniform_(generator_); }
  Mat3 matrix(double size) {
    return Mat3::NullaryExpr([&] { return size * (*this)(); });
  }

 private:
  std::mt19937_64 generator_{11};
  std::uniform_real_distribution<double> uniform_{-1.0, 1.0};
};

Matrix3<double> to_matrix3(const Mat3& a) {
  Matrix3<double> r;
  for (int i = 0; i < 3; ++i)
    for (int j = 0; j < 3; ++j) r.m[i][j] = a(i, j);
  return r;
}
Mat3 stress_matrix(const MaterialState<double>& s) {
  Mat3 r;
  r << s.stress.xx, s.stress.xy, s.stress.xz, s.stress.xy, s.stress.yy, s.stress.yz, s.stress.xz, s.stress.yz, s.stress.zz;
  return r;
}

/// Runs the same test on every law of the table.
template <class F>
void for_every_law(F f) {
  for (const Entry& entry : mpm::testing::typical_materials()) {
    SCOPED_TRACE(std::string(entry.name()));
    std::visit([&](const auto& law) { f(law, entry); }, make_material(entry));
  }
}

// A stress of E times 1e-12 is round-off of strains up to a few per cent after the few steps of these tests.
double round_off(const Entry&) { return 1e-12 * HenckyModuli::Parameters{}.young_modulus; }

/// A law whose member that it names is misspelt, one that does not name a member, and one that agrees.
struct MisspeltViscosity : HenckyElastic {
  using HenckyElastic::HenckyElastic;
  static constexpr OptionalMembers has{.try_update_stress = true, .viscosity = true};
  [[nodiscard]] static double viscocity() { return 1.0; }
};
struct UnnamedViscosity : HenckyElastic {
  using HenckyElastic::HenckyElastic;
  [[nodiscard]] static double viscosity() { return 1.0; }
};
struct NamedViscosity : UnnamedViscosity {
  using UnnamedViscosity::UnnamedViscosity;
  static constexpr OptionalMembers has{.try_update_stress = true, .viscosity = true};
};

TEST(EveryLaw, HasTheOptionalMembersThatItNames) {
  EXPECT_FALSE(Material<MisspeltViscosity>);
  EXPECT_FALSE(Material<UnnamedViscosity>);
  EXPECT_TRUE(Material<NamedViscosity>);
}

TEST(EveryLaw, HasATypicalMaterial) {
  for (const LawInfo& law : all_laws()) {
    EXPECT_TRUE(std::ranges::any_of(mpm::testing::typical_materials(), [&](const Entry& entry) { return entry.name() == law.name; }))
        << law.name << " is missing in tests/support/typical_materials.hpp";
  }
}

/// All numbers with which a run computes a law in double precision.
template <class T>
class EveryLawInLanes : public ::testing::Test {};
using LaneNumbers = ::testing::Types<Lanes, LanePair, HalfPair>;
TYPED_TEST_SUITE(EveryLawInLanes, LaneNumbers);

TYPED_TEST(EveryLawInLanes, GivesTheSameAsAlone) {
  for_every_law([](const auto& law, [[maybe_unused]] const Entry& entry) {
    constexpr int count = lanes_of<TypeParam>;
    Random random;
    MaterialState<double> alone[count];
    MaterialState<TypeParam> lanes{};
    lanes.internal = broadcast<TypeParam>(law.initial_internal());
    for (auto& s : alone) s = {{}, law.initial_internal()};
    for (int step = 0; step < 50; ++step) {
      Matrix3<TypeParam> dl{};
      for (int i = 0; i < count; ++i) {
        const Matrix3<double> one = to_matrix3(random.matrix(strain_in_step));
        for (int a = 0; a < 3; ++a)
          for (int b = 0; b < 3; ++b) set_lane(dl.m[a][b], i, one.m[a][b]);
        law.update_stress(alone[i], one, 1e-3);
      }
      law.update_stress(lanes, dl, 1e-3);
      for (int i = 0; i < count; ++i) {
        const MaterialState<double> one{{lane(lanes.stress.xx, i), lane(lanes.stress.yy, i), lane(lanes.stress.zz, i),
                                         lane(lanes.stress.xy, i), lane(lanes.stress.xz, i), lane(lanes.stress.yz, i)},
                                        lane(lanes.internal, i)};
        ASSERT_LE((stress_matrix(one) - stress_matrix(alone[i])).cwiseAbs().maxCoeff(), 10.0 * round_off(entry)) << step;
        ASSERT_NEAR(one.internal, alone[i].internal, 1e-11) << step;
        ASSERT_NEAR(law.volume_ratio(one), law.volume_ratio(alone[i]), 1e-11) << step;
      }
    }
  });
}

TEST(EveryLaw, GivesTheSameVolumeInLanesAsAlone) {
  for_every_law([](const auto& law, [[maybe_unused]] const Entry& entry) {
    MaterialState<double> alone{{}, law.initial_internal()};
    law.update_stress(alone, to_matrix3(Random().matrix(strain_in_step)), 1e-3);
    MaterialState<Lanes> lanes{};
    lanes.stress.xx = broadcast<Lanes>(alone.stress.xx), lanes.stress.yy = broadcast<Lanes>(alone.stress.yy);
    lanes.stress.zz = broadcast<Lanes>(alone.stress.zz), lanes.internal = broadcast<Lanes>(alone.internal);
    const Lanes ratio = law.volume_ratio(lanes);
    for (int i = 0; i < lanes_of<Lanes>; ++i) EXPECT_NEAR(ratio[i], law.volume_ratio(alone), 1e-14);
  });
}

TEST(EveryLaw, TracksTheVolume) {
  for_every_law([](const auto& law, [[maybe_unused]] const Entry& entry) {
    Random random;
    MaterialState<double> s{{}, law.initial_internal()};
    EXPECT_DOUBLE_EQ(law.volume_ratio(s), 1.0);
    double det = 1.0;
    for (int step = 0; step < 200; ++step) {
      const Mat3 dl = random.matrix(strain_in_step);
      law.update_stress(s, to_matrix3(dl), 1e-3);
      det *= (Mat3::Identity() + dl).determinant();
      ASSERT_NEAR(law.volume_ratio(s) / det, 1.0, 1e-15 * (step + 10)) << step;  // round-off adds up, at most an ulp or so a step
    }
  });
}

TEST(EveryLaw, IsObjective) {
  // A rotated material under a rotated increment gives the rotated stress and the same internal variable.
  for_every_law([](const auto& law, [[maybe_unused]] const Entry& entry) {
    Random random;
    const Mat3 r = Eigen::Quaterniond(0.3, -0.5, 0.7, 0.2).normalized().toRotationMatrix();
    MaterialState<double> a{{}, law.initial_internal()}, b = a;
    for (int step = 0; step < 20; ++step) {
      const Mat3 dl = random.matrix(strain_in_step);
      law.update_stress(a, to_matrix3(dl), 1e-3);
      law.update_stress(b, to_matrix3(r * dl * r.transpose()), 1e-3);
      ASSERT_LE((r * stress_matrix(a) * r.transpose() - stress_matrix(b)).cwiseAbs().maxCoeff(), 100.0 * round_off(entry)) << step;
      ASSERT_NEAR(a.internal, b.internal, 1e-11);
    }
  });
}

TEST(EveryLaw, ARotationTurnsTheStressAndDoesNothingElse) {
  for_every_law([](const auto& law, [[maybe_unused]] const Entry& entry) {
    Random random;
    MaterialState<double> s{{}, law.initial_internal()};
    Mat3 compression = random.matrix(0.1 * strain_in_step);
    compression.diagonal().array() -= 0.1 * strain_in_step;
    law.update_stress(s, to_matrix3(compression), 1e-3);
    const Mat3 r = Eigen::AngleAxisd(0.4, Vec3(1.0, 2.0, -0.5).normalized()).toRotationMatrix();
    MaterialState<double> turned = s;
    law.update_stress(turned, to_matrix3(r - Mat3::Identity()), 1e-3);
    EXPECT_LE((r * stress_matrix(s) * r.transpose() - stress_matrix(turned)).cwiseAbs().maxCoeff(), round_off(entry));
    EXPECT_NEAR(turned.internal, s.internal, 1e-14);
  });
}

TEST(EveryLaw, NeverStoresMoreEnergyThanIsSupplied) {
  // Supplied: the integral of tau : d, by the trapezoidal rule in steps so small that its error is below 1e-4 of the sum of |tau : d dt|.
  for_every_law([](const auto& law, [[maybe_unused]] const Entry& entry) {
    Random random;
    MaterialState<double> s{{}, law.initial_internal()};
    EXPECT_EQ(law.stored_energy(s), 0.0);
    double work = 0.0, turnover = 0.0;
    for (int leg = 0; leg < 10; ++leg) {
      const int steps = 400;
      const Mat3 dl = random.matrix(strain_in_step) / steps;
      for (int step = 0; step < steps; ++step) {
        const Mat3 before = stress_matrix(s);
        law.update_stress(s, to_matrix3(dl), 1e-3);
        const double supplied = 0.5 * (before + stress_matrix(s)).cwiseProduct(0.5 * (dl + dl.transpose())).sum();
        work += supplied, turnover += std::fabs(supplied);
      }
      EXPECT_GE(law.stored_energy(s), 0.0);
      EXPECT_LE(law.stored_energy(s), work + 1e-3 * turnover) << leg;
    }
  });
}

TEST(EveryLaw, HasASoundWaveSpeedAndDensity) {
  for_every_law([](const auto& law, [[maybe_unused]] const Entry& entry) {
    EXPECT_EQ(law.density(), entry.density());
    EXPECT_GT(law.wave_speed(), 0.0);
    EXPECT_TRUE(std::isfinite(law.wave_speed()));
  });
}

/// The parameters of every law, one value after the other outside of its range.
template <class P>
void refuses_what_is_out_of_range(const P& sound) {
  SCOPED_TRACE(std::string(P::name));
  EXPECT_NO_THROW(make_material(sound));
  for (const Parameter<P>& p : parameters_of<P>().all()) {
    if (!p.info.range) continue;
    const double span = p.info.range->high - p.info.range->low;
    for (const double bad : {p.info.range->low - span, p.info.range->high + span, std::nan("")}) {
      if (p.info.type == ParameterType::integer && std::isnan(bad)) continue;
      P broken = sound;
      p.set(broken, p.info.type == ParameterType::integer ? ParameterValue(static_cast<std::int64_t>(bad)) : ParameterValue(bad));
      try {
        make_material(broken);
        ADD_FAILURE() << p.info.name << " = " << bad << " is taken";
      } catch (const ConfigError& error) {
        const std::string message = error.what();
        EXPECT_TRUE(message.find(p.info.name + " = ") != std::string::npos) << message;
        EXPECT_TRUE(message.find("give " + expected_value(p.info)) != std::string::npos) << message;
      }
    }
  }
}

TEST(EveryLaw, RefusesParametersOutsideTheRangesThatItDeclares) {
  for (const Entry& entry : mpm::testing::typical_materials())
    std::visit([](const auto& p) { refuses_what_is_out_of_range(p); }, entry.law);
}

TEST(EveryLaw, DeclaresAParameterThatItSharesAsTheOthersDo) {
  for (const Parameter<MaterialParameters>& shared : parameters_of<MaterialParameters>().all()) {
    for (const Entry& entry : mpm::testing::typical_materials()) {
      std::visit(
          [&]<class P>(const P&) {
            for (const Parameter<P>& own : parameters_of<P>().all()) {
              if (own.info.name != shared.info.name) continue;
              EXPECT_EQ(own.info.unit, shared.info.unit) << own.info.name;
              EXPECT_EQ(own.info.range, shared.info.range) << own.info.name;
              EXPECT_EQ(own.info.type, shared.info.type) << own.info.name;
            }
          },
          entry.law);
    }
  }
}

}  // namespace
