#include "libmpm/source/lattice.hpp"

#include <algorithm>
#include <array>
#include <random>
#include <vector>

namespace mpm {

namespace {

using Dart = std::array<std::int64_t, 3>;  ///< in parts of a cell: whole numbers, so that every compiler keeps the same darts
constexpr int part_bits = 16, place_bits = 21;
constexpr std::int64_t parts = 1 << part_bits, places = 1 << place_bits;
static_assert(places == random_period * parts);

std::size_t cell_number(long i, long j, long k) {
  return static_cast<std::size_t>((k % random_period * random_period + j % random_period) * random_period + i % random_period);
}

class RandomPoints {
 public:
  RandomPoints() : cells_(cell_number(-1 + random_period, -1 + random_period, -1 + random_period) + 1) {
    constexpr std::int64_t middle = parts / 2;
    std::mt19937_64 dice;                  // one number of 64 bits is three places
    Dart dart = {middle, middle, middle};  // the first cell has a particle: a body of one cell consists of it
    for (std::size_t count = 0; count < cells_.size(); dart = thrown(dice())) {
      if (!is_free(dart)) continue;
      cells_[cell_number(dart[0] / parts, dart[1] / parts, dart[2] / parts)].darts.push_back(dart);
      ++count;
    }
    for (Cell& cell : cells_) {
      for (const Dart& d : cell.darts) {
        const auto from_middle = [](std::int64_t place) { return (static_cast<double>(place % parts) + 0.5) / parts - 0.5; };
        cell.points.emplace_back(from_middle(d[0]), from_middle(d[1]), from_middle(d[2]));
      }
    }
  }
  [[nodiscard]] std::span<const Vec3> in(std::size_t cell) const { return cells_[cell].points; }

 private:
  struct Cell {
    std::vector<Dart> darts;
    std::vector<Vec3> points;
  };

  static Dart thrown(std::uint64_t number) {
    const auto place = [&](int bit) { return static_cast<std::int64_t>(number >> bit) & (places - 1); };
    return {place(0), place(place_bits), place(2 * place_bits)};
  }

  [[nodiscard]] bool is_free(const Dart& dart) const {
    constexpr auto least = static_cast<std::int64_t>(random_distance * parts);
    for (int n = 13; n < 13 + 27; ++n) {  // the dart's own cell first, where most are refused, and those around it
      const auto cell = [&](std::size_t axis, int step) { return dart[axis] / parts + random_period + step - 1; };
      for (const Dart& other : cells_[cell_number(cell(0, n % 3), cell(1, n / 3 % 3), cell(2, n / 9 % 3))].darts) {
        std::int64_t square = 0;
        for (std::size_t axis = 0; axis < 3; ++axis) {
          const std::int64_t apart = std::llabs(dart[axis] - other[axis]), way = std::min(apart, places - apart);
          square += way * way;
        }
        if (square < least * least) return false;
      }
    }
    return true;
  }

  std::vector<Cell> cells_;
};

}  // namespace

std::span<const Vec3> random_points(long i, long j, long k) {
  static const RandomPoints points;
  return points.in(cell_number(i, j, k));
}

}  // namespace mpm
