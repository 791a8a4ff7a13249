#include "libmpm/core/boundary_impulses.hpp"

#include <algorithm>
#include <cstring>

namespace mpm {

namespace {

/// An impulse in a message.
using ImpulseNumbers = std::array<double, 7>;
static_assert(sizeof(Impulse) == sizeof(ImpulseNumbers) && sizeof(Vec3) == 3 * sizeof(double));

ImpulseNumbers numbers_of(const Impulse& impulse) {
  ImpulseNumbers numbers;
  std::memcpy(numbers.data(), static_cast<const void*>(&impulse), sizeof numbers);
  return numbers;
}
Impulse impulse_of(const ImpulseNumbers& numbers) {
  Impulse impulse;
  std::memcpy(static_cast<void*>(&impulse), numbers.data(), sizeof numbers);
  return impulse;
}

/// Whether all bits are zero: such a term would change no sum, and most blocks touch no boundary.
template <class T>
bool is_nothing(const T& value) {
  static constexpr std::byte nothing[sizeof(T)] = {};
  return std::memcmp(static_cast<const void*>(&value), nothing, sizeof(T)) == 0;
}

/// The message of a ContactImpulse.
void put_contact(Message& message, const ContactImpulse& impulse) {
  put(message, impulse.first);
  put(message, impulse.sides.size());
  for (const Impulse& side : impulse.sides) put(message, numbers_of(side));
  for (const auto& face : impulse.faces) {
    put(message, face.size());
    for (const ContactImpulse::Part& part : face) {
      put(message, part.layer);
      put(message, numbers_of(part.impulse));
    }
  }
}
ContactImpulse get_contact(MessageReader& reader) {
  ContactImpulse impulse{.first = reader.get<std::int32_t>()};
  impulse.sides.resize(reader.get<std::size_t>());
  for (Impulse& side : impulse.sides) side = impulse_of(reader.get<ImpulseNumbers>());
  for (auto& face : impulse.faces) {
    face.resize(reader.get<std::size_t>());
    for (ContactImpulse::Part& part : face) {
      part.layer = reader.get<std::int32_t>();
      part.impulse = impulse_of(reader.get<ImpulseNumbers>());
    }
  }
  return impulse;
}

}  // namespace

Impulse& ContactImpulse::side(std::int32_t layer) {
  if (sides.empty()) first = layer;
  if (layer < first) {  // beside the columns of the stencil there may be material in other layers
    sides.insert(sides.begin(), static_cast<std::size_t>(first - layer), Impulse{});
    first = layer;
  }
  const auto place = static_cast<std::size_t>(layer - first);
  if (place >= sides.size()) sides.resize(place + 1);
  return sides[place];
}

ContactImpulse& ContactImpulse::operator+=(const ContactImpulse& other) {
  for (std::size_t k = 0; k < other.sides.size(); ++k) side(other.first + static_cast<std::int32_t>(k)) += other.sides[k];
  for (std::size_t f = 0; f < faces.size(); ++f) faces[f].insert(faces[f].end(), other.faces[f].begin(), other.faces[f].end());
  return *this;
}

Impulse ContactImpulse::total() const {
  Impulse sum;
  for (const Impulse& layer : sides) sum += layer;
  for (const auto& face : faces) {
    for (const Part& part : face) sum += part.impulse;
  }
  return sum;
}

LayerImpulses ContactImpulse::layers() const {
  LayerImpulses sum{.first = first};
  for (const Impulse& layer : sides) sum.layer.push_back(layer.linear);
  for (const auto& face : faces) {
    for (const Part& part : face) sum.layer[static_cast<std::size_t>(part.layer - first)] += part.impulse.linear;
  }
  return sum;
}

void ImpulseRecord::add_impulse(std::size_t b, const Impulse& taken) {
  if (!is_nothing(taken)) sums_.add_members(1 + impulse_numbers * b, taken);
}

void ImpulseRecord::add_layers(std::size_t k, const Index3& block, std::span<const Vec3, block_edge> layers) {
  BlockLayers row{block, {}};
  std::memcpy(row.numbers.data(), static_cast<const void*>(layers.data()), sizeof row.numbers);
  if (!is_nothing(row.numbers)) layers_[k].push_back(row);
}

/// Afterwards the first rank has the rows of all ranks, and the others have none.
void ImpulseRecord::gather_layers(std::vector<BlockLayers>& rows, RankGroup& ranks) const {
  Message mine;
  for (const BlockLayers& row : rows) {
    put(mine, row.block);
    put(mine, row.numbers);
  }
  rows.clear();
  for (const Message& message : ranks.gather(std::move(mine))) {
    for (MessageReader reader(message); !reader.at_end();) {
      BlockLayers& row = rows.emplace_back();
      row.block = reader.get<Index3>();
      row.numbers = reader.get<decltype(row.numbers)>();
    }
  }
  std::ranges::sort(rows, comes_before, &BlockLayers::block);  // each block is of one rank
}

/// Afterwards the first rank has the impulses of a run on one rank, and the others have none.
void ImpulseRecord::gather_contacts(RankGroup& ranks) {
  Message mine;
  for (const auto& [b, impulse] : contacts_) {
    if (impulse.sides.empty()) continue;
    put(mine, b);
    put_contact(mine, impulse);
  }
  contacts_.clear();
  for (const Message& message : ranks.gather(std::move(mine))) {
    for (MessageReader reader(message); !reader.at_end();) {
      const auto boundary = reader.get<std::size_t>();
      contacts_[boundary] += get_contact(reader);
    }
  }
}

/// Adds the impulses on the four layers of each block, in the order of the blocks.
LayerImpulses ImpulseRecord::sum_of(std::span<const BlockLayers> rows) {
  constexpr std::int32_t edge = block_edge;
  LayerImpulses sum;
  if (rows.empty()) return sum;
  const auto [lowest, highest] = std::ranges::minmax(rows, {}, [](const BlockLayers& row) { return row.block[2]; });
  sum.first = first_node(lowest.block[2]);
  sum.layer.assign(static_cast<std::size_t>(edge * (highest.block[2] - lowest.block[2] + 1)), Vec3::Zero());
  for (const BlockLayers& row : rows) {
    Vec3* const layers = &sum.layer[static_cast<std::size_t>(edge * (row.block[2] - lowest.block[2]))];
    for (int k = 0; k < edge; ++k) layers[k] += Eigen::Map<const Vec3>(row.numbers.data() + 3 * k);
  }
  return sum;
}

BoundaryImpulses ImpulseRecord::total(RankGroup& ranks) && {
  sums_.add_ranks(ranks);
  BoundaryImpulses whole;
  whole.mass = sums_.value(0);
  for (std::size_t b = 0; b < boundaries_; ++b) whole.impulses.push_back(sums_.members<Impulse>(1 + impulse_numbers * b));
  for (std::size_t k = 0; k < layers_.size(); ++k) {
    if (ranks.size() > 1 && !contacts_.contains(layered_[k])) gather_layers(layers_[k], ranks);
    whole.layers.push_back(sum_of(layers_[k]));
  }
  if (ranks.size() > 1 && !contacts_.empty()) gather_contacts(ranks);
  for (const auto& [b, impulse] : contacts_) {
    whole.impulses[b] = impulse.total();
    const auto place = std::ranges::find(layered_, b);
    if (place != layered_.end()) whole.layers[static_cast<std::size_t>(place - layered_.begin())] = impulse.layers();
  }
  return whole;
}

}  // namespace mpm
