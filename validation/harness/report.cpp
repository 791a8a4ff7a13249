#include "validation/harness/report.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <string>

#include "libmpm/io/atomic_file.hpp"
#include "libmpm/io/csv.hpp"
#include "validation/harness/junit.hpp"
#include "validation/harness/orders.hpp"
#include "validation/harness/results_json.hpp"

namespace mpm::validation {

void write_results(const std::filesystem::path& directory, const std::vector<CaseResult>& results, RunInfo info) {
  info.directory = directory;
  make_directory(directory / "data");
  for (const CaseResult& r : results)
    for (const Plot& p : r.plots) {
      std::string csv = fmt::format("# {}: {}\n# x: {}; y: {}\nseries,x,y\n", r.title, p.title, p.x_label, p.y_label);
      for (const Series& s : p.series)
        for (std::size_t i = 0; i < std::min(s.x.size(), s.y.size()); ++i)
          csv += csv_line(std::vector<std::string>{s.name, format_number(s.x[i]), format_number(s.y[i])});
      write_file(directory / "data" / fmt::format("{}-{}.csv", r.name, p.id), csv);
    }
  write_file(directory / "orders.csv", orders_csv(results));
  write_file(directory / "junit.xml", junit_xml(results, info));
  write_file(directory / "results.json", results_json(results, info));
}

}  // namespace mpm::validation
