#include "libmpm/observe/observer_list.hpp"

#include <algorithm>
#include <iterator>
#include <limits>

#include "libmpm/io/csv.hpp"
#include "libmpm/parallel/block_exchange.hpp"
#include "libmpm/parallel/ownership.hpp"

namespace mpm {

namespace {

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();
constexpr const char* series_name = "series";

std::vector<Column> columns_of(const std::vector<std::shared_ptr<Observer>>& observers) {
  std::vector<Column> columns;
  for (const auto& o : observers) std::ranges::move(o->columns(), std::back_inserter(columns));
  return columns;
}

/// The means over the steady interval by height; without one only the header.
std::string profile_table(const std::vector<HeightProfile>& profiles, bool steady) {
  std::vector<std::string> names;
  std::vector<std::vector<double>> means;
  for (const HeightProfile& profile : profiles) {
    names.push_back(profile.column.name());
    means.push_back(steady ? profile.mean : std::vector<double>());
  }
  return names.empty() ? "" : table_text(names, means);
}

using Observers = std::span<const std::shared_ptr<Observer>>;

bool visited(Observers observers, const ParticleBatch& batch) {
  return std::ranges::any_of(observers, [&](const auto& o) { return o->visits(batch.low, batch.high); });
}

/// One loop over all particles serves all observers: block by block, those of other ranks in their places.
void visit_all(Observers observers, const State& state, const Scene& scene) {
  const Grid& own = state.grid;
  Grid others(own.cell_size(), own.precision());
  own.ranks().instruct(Task::observe, state);
  collect_blocks(
      own, [&](const Block& block) { return visited(observers, ParticleBatch(block, scene, own.cell_size())); }, others);
  own.ranks().done();
  const auto a = own.occupied_blocks(), b = others.occupied_blocks();
  for (std::size_t i = 0, j = 0; i < a.size() || j < b.size();) {
    const bool from_own = j == b.size() || (i < a.size() && comes_before(own.block(a[i]).coordinate, others.block(b[j]).coordinate));
    const ParticleBatch batch(from_own ? own.block(a[i++]) : others.block(b[j++]), scene, own.cell_size());
    for (const auto& o : observers) {
      if (o->visits(batch.low, batch.high)) o->visit(batch);
    }
  }
}

/// Arrays under "owner.name".
void store(Arrays& all, const std::string& owner, Arrays&& own) {
  for (auto& [name, values] : own) all[owner + "." + name] = std::move(values);
}
Arrays stored(const Arrays& all, const std::string& owner) {
  const std::string prefix = owner + ".";
  Arrays own;
  for (auto it = all.lower_bound(prefix); it != all.end() && it->first.starts_with(prefix); ++it)
    own[it->first.substr(prefix.size())] = it->second;
  return own;
}

}  // namespace

MeanEstimate Summary::mean(std::string_view column) const { return mean(series[column]); }

std::span<const double> Summary::steady_part(std::span<const double> values) const {
  return values.subspan(span.first, span.last - span.first);
}

MeanEstimate Summary::mean(std::span<const double> values) const { return estimate_mean(steady_part(values)); }

double Summary::peak(std::string_view column) const { return peak_of(series[column]).value; }

std::vector<double> Summary::mean_rows(std::span<const double> values, std::size_t width) const {
  if (!span.steady) return {};
  std::vector<double> mean(width, 0.0);
  for (std::size_t sample = span.first; sample < span.last; ++sample) {
    for (std::size_t i = 0; i < width; ++i) mean[i] += values[sample * width + i];
  }
  for (double& m : mean) m /= static_cast<double>(span.last - span.first);
  return mean;
}

ObserverList::ObserverList(std::vector<std::shared_ptr<Observer>> observers)
    : observers_(std::move(observers)), series_(columns_of(observers_)) {
  for (const auto& o : observers_) width_.push_back(o->columns().size());
}

void ObserverList::begin(const State& state, const Scene& scene) {
  for (const auto& o : observers_) o->begin(state, scene);
}

void ObserverList::after_step(const StepReport& report, const State& state) {
  for (const auto& o : observers_) o->after_step(report, state);
}

std::vector<double> ObserverList::sample(const Instant& now) {
  visit_all(observers_, now.live->state, now.live->scene);
  std::vector<double> row(series_.names().size(), unknown);
  row.front() = now.time;
  auto place = row.begin() + 1;
  for (std::size_t i = 0; i < observers_.size(); place += static_cast<std::ptrdiff_t>(width_[i++]))
    observers_[i]->sample(now, std::span(place, width_[i]));
  series_.append(row);
  return row;
}

bool ObserverList::visits(const Block& block, const Scene& scene, double cell_size) const {
  return visited(observers_, ParticleBatch(block, scene, cell_size));
}

std::vector<double> ObserverList::sample(const Snapshot& frame, const std::function<double(const Column&)>& carried) {
  const ParticleBatch batch(frame);
  std::vector<double> row(series_.names().size(), unknown);
  row.front() = frame.info.time;
  std::size_t place = 1;
  for (std::size_t i = 0; i < observers_.size(); place += width_[i++]) {
    if (observers_[i]->measured_from() == MeasuredFrom::frames) {
      observers_[i]->visit(batch);
      observers_[i]->sample({.time = frame.info.time}, std::span(row).subspan(place, width_[i]));
    } else {
      for (std::size_t k = place; k < place + width_[i]; ++k) row[k] = carried(series_.columns()[k]);
    }
  }
  series_.append(row);
  return row;
}

std::vector<std::string> ObserverList::check(const Instant& now) {
  std::vector<std::string> warnings;
  for (const auto& o : observers_) std::ranges::move(o->check(now), std::back_inserter(warnings));
  return warnings;
}

bool ObserverList::may_end() const {
  return std::ranges::any_of(observers_, [this](const auto& o) { return o->may_end(series_); });
}

Summary ObserverList::summary(const State* state, const RunProgress* progress) const {
  Summary end{.series = series_, .state = state, .progress = progress};
  for (const auto& o : observers_) {
    if (const auto span = o->steady_interval(series_)) end.span = *span;
  }
  for (const auto& o : observers_) std::ranges::move(o->profiles(end), std::back_inserter(end.profiles));
  end.profile = profile_table(end.profiles, end.span.steady);
  return end;
}

Results ObserverList::results(const Summary& end) const {
  Results results;
  for (const auto& o : observers_) {
    if (end.state != nullptr || o->measured_from() == MeasuredFrom::frames) results.add(o->summary(end));
  }
  return results;
}

Arrays ObserverList::save() const {
  Arrays all;
  store(all, series_name, series_.save());
  for (const auto& o : observers_) store(all, o->name(), o->save());
  return all;
}

void ObserverList::load(const Arrays& arrays, std::size_t samples) {
  series_.load(stored(arrays, series_name), samples);
  for (const auto& o : observers_) o->load(stored(arrays, o->name()), samples);
}

std::vector<double> measure(Observer& observer, const State& state, const Scene& scene) {
  const std::shared_ptr<Observer> borrowed(&observer, [](Observer*) {});
  visit_all({&borrowed, 1}, state, scene);
  std::vector<double> row(observer.columns().size(), unknown);
  const LiveState live{state, scene, totals(state, scene)};
  observer.sample({.time = state.time, .live = &live}, row);
  return row;
}

}  // namespace mpm
