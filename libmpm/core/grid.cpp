#include "libmpm/core/grid.hpp"

#include <algorithm>
#include <bit>
#include <cstring>

#include "libmpm/base/bspline.hpp"
#include "libmpm/base/error.hpp"

namespace mpm {

namespace {

constexpr std::int32_t coordinate_limit = 1 << 20;  // 21 bits an axis

std::uint64_t key_of(const Index3& c) {
  const auto part = [](std::int32_t v) { return static_cast<std::uint64_t>(v + coordinate_limit); };
  return part(c[2]) << 42 | part(c[1]) << 21 | part(c[0]);
}

}  // namespace

std::int32_t Grid::find_any(const Index3& coordinate) const {
  const auto it = index_.find(key_of(coordinate));
  return it == index_.end() ? no_block : it->second;
}

std::int32_t Grid::find(const Index3& coordinate) const {
  const std::int32_t index = find_any(coordinate);
  return index == no_block || block(index).owned ? index : no_block;
}

std::int32_t Grid::find_or_create(const Index3& coordinate) {
  const std::int32_t index = find_any(coordinate);
  return index == no_block ? create(coordinate) : index;
}

void Grid::divide(Ranks& ranks) {
  ranks_ = &ranks;
  ask_owners();
}

void Grid::ask_owners() {
  for (const auto& [key, index] : index_) ask_owner(block(index));
  set_changed_ = true;
}

void Grid::ask_owner(Block& b) const {
  b.owned = ranks_->owns(b.coordinate);
  b.at_border = ranks_->at_border(b.coordinate);
}

std::int32_t Grid::new_buffer() {
  buffers_.push_back(new_storage());
  return buffers_.back();
}

void Grid::free_buffers() {
  free_.insert(free_.end(), buffers_.begin(), buffers_.end());
  buffers_.clear();
}

std::int32_t Grid::new_storage() {
  if (!free_.empty()) {
    const std::int32_t index = free_.back();
    free_.pop_back();
    return index;
  }
  blocks_.emplace_back();
  blocks_.back().particles = ParticleBin(precision_);
  nodes_.emplace_back();
  if (forces_apart_) forces_.emplace_back();
  return static_cast<std::int32_t>(blocks_.size()) - 1;
}

std::int32_t Grid::create(const Index3& coordinate) {
  for (const auto c : coordinate) {
    if (c <= -coordinate_limit || c >= coordinate_limit)
      throw UnstableError("a particle is more than a million blocks away from the origin");
  }
  const std::int32_t index = new_storage();
  Block& b = block(index);
  b.coordinate = coordinate;
  b.particles.frame = {coordinate, cell_size_, Vec3::Zero()};
  ask_owner(b);
  for (int n = 0; n < 27; ++n) {
    const std::int32_t other = n == 13 ? index : find_any(neighbour_of(coordinate, n));
    b.neighbour[static_cast<std::size_t>(n)] = other;
    if (other != no_block && n != 13) block(other).neighbour[static_cast<std::size_t>(26 - n)] = index;
  }
  index_.emplace(key_of(coordinate), index);
  set_changed_ = true;
  return index;
}

void Grid::destroy(std::int32_t index) {
  Block& b = block(index);
  for (int n = 0; n < 27; ++n) {
    const std::int32_t other = b.neighbour[static_cast<std::size_t>(n)];
    if (other != no_block) block(other).neighbour[static_cast<std::size_t>(26 - n)] = no_block;
  }
  index_.erase(key_of(b.coordinate));
  b.particles.release(*pool_);
  b.outbox = {};
  b.buffers = nullptr;
  b.outer = false;
  free_.push_back(index);
  set_changed_ = true;
}

void Grid::insert(const Particle& p) {
  const auto base = [&](int axis) { return base_node(p.position[axis] * inverse_cell_size_); };
  const Index3 node = {base(0), base(1), base(2)}, coordinate = block_of_node(node);
  if (!ranks_->owns(coordinate)) return;  // the caller passes all particles to every rank, which keeps its own
  block(find_or_create(coordinate)).particles.append(p, number_of_node(node), *pool_);
}

void Grid::restore(const StoredBlock& stored) {
  ParticleBin& bin = block(find_or_create(stored.coordinate)).particles;
  bin.frame.velocity = stored.velocity;
  const std::size_t size = record_bytes(precision_);
  for (std::size_t i = 0; i < stored.cells.size(); ++i) {
    bin.append(stored.cells[i], *pool_);
    std::memcpy(bin.bytes(bin.count() - 1).data(), stored.records.data() + i * size, size);
  }
}

void Grid::migrate() {
  ranks_->exchange_migrants(*this);
  for (const auto* list : {&occupied_, &ghosts_}) {
    for (const auto b : *list) {
      for (std::uint32_t left = block(b).outbox.neighbours; left != 0; left &= left - 1) {
        const int to = std::countr_zero(left);
        if (block(b).neighbour[static_cast<std::size_t>(to)] == no_block) create(neighbour_of(block(b).coordinate, to));
      }
    }
  }
  if (set_changed_) rebuild_lists();
  bool out_of_memory = false;
#pragma omp parallel for schedule(dynamic, 4)
  for (std::size_t i = 0; i < own_.size(); ++i) {  // each block collects its particles from its neighbours, in a fixed order
    Block& self = block(own_[i]);
    try {
      for (int n = 0; n < 27; ++n) {
        const std::int32_t other = self.neighbour[static_cast<std::size_t>(n)];
        if (other == no_block || (block(other).outbox.neighbours >> (26 - n) & 1U) == 0) continue;
        block(other).outbox.for_each([&](const Migrant& m) {
          if (m.to == 26 - n) self.particles.append(m.particle, m.cell, *pool_);
        });
      }
      if (self.particles.count() > 0) self.particles.sort_by_cell();
    } catch (const std::bad_alloc&) {
#pragma omp atomic write
      out_of_memory = true;
    }
  }
  if (out_of_memory) throw std::bad_alloc();
  for (const auto* list : {&own_, &ghosts_}) {  // not occupied_: a block that lost its last particle has an outbox too
    for (const auto b : *list) block(b).outbox = {};
  }
  migrants_.clear();
  refresh();
  for (const auto b : occupied_) {
    if (block(b).particles.count() > max_particles_per_block) {
      throw UnstableError("more than 65000 particles in one block of 4 x 4 x 4 cells: the material has collapsed into a point");
    }
  }
}

void Grid::refresh() {
  std::vector<char> needed(blocks_.size(), 0);  // grows with the blocks: what is created below is needed
  const auto need = [&](std::int32_t b) {
    if (static_cast<std::size_t>(b) >= needed.size()) needed.resize(blocks_.size(), 0);
    needed[static_cast<std::size_t>(b)] = 1;
  };
  for (std::size_t i = 0; i < blocks_.size(); ++i) {
    ParticleBin& bin = block(static_cast<std::int32_t>(i)).particles;
    if (bin.count() == 0) continue;
    if (bin.order.size() != bin.cell.size()) bin.sort_by_cell();
    for (const int direction : forward_directions) {
      std::int32_t n = block(static_cast<std::int32_t>(i)).neighbour[static_cast<std::size_t>(direction)];
      if (n == no_block) n = create(neighbour_of(block(static_cast<std::int32_t>(i)).coordinate, direction));
      need(n);
    }
  }
  if (ranks_->size() > 1) {
    rebuild_lists();
    for (const std::int32_t b : ranks_->announce(*this)) need(b);
    rebuild_lists();
  }
  for (const auto* list : {&own_, &ghosts_}) {
    for (const auto b : *list) {
      if (needed[static_cast<std::size_t>(b)] == 0) destroy(b);
    }
  }
  rebuild_lists();
  ranks_->plan(*this);
}

void Grid::rebuild_lists() {
  if (set_changed_) {
    own_.clear();
    ghosts_.clear();
    for (const auto& [key, index] : index_) (block(index).owned ? own_ : ghosts_).push_back(index);
    for (auto* list : {&own_, &ghosts_}) {
      std::sort(list->begin(), list->end(),
                [this](std::int32_t a, std::int32_t b) { return comes_before(block(a).coordinate, block(b).coordinate); });
    }
    set_changed_ = false;
  }
  occupied_.clear();
  for (auto& list : coloured_) list.clear();
  for (const auto b : own_) {
    if (block(b).particles.count() == 0) continue;
    occupied_.push_back(b);
    coloured_[static_cast<std::size_t>(colour_of(block(b).coordinate))].push_back(b);
  }
}

std::size_t Grid::particle_count() const {
  std::size_t n = 0;
  for (const auto b : occupied_) n += static_cast<std::size_t>(block(b).particles.count());
  return ranks_->particle_count(n);
}

std::size_t Grid::bytes() const {
  std::size_t n = pool_->bytes() + migrants_.bytes() + (nodes_.size() + forces_.size() + scratch_.size()) * sizeof(NodeBlock) +
                  blocks_.size() * sizeof(Block);
  for (const auto& b : blocks_) n += b.particles.cell.capacity() + 2 * b.particles.order.capacity();
  return n;
}

}  // namespace mpm
