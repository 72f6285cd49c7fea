// Files of named columns, as benchmarks/exchange.py writes them: a line per column (name, type,
// dimensions), an empty line, then the values in the same order, little-endian.
#pragma once

#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <map>
#include <sstream>
#include <string>
#include <tuple>
#include <vector>

[[noreturn]] inline void fail(const std::string& message) {
  std::fprintf(stderr, "%s\n", message.c_str());
  std::exit(2);
}

class Columns {
 public:
  explicit Columns(const std::string& path) {
    std::ifstream file(path, std::ios::binary);
    if (!file) fail(path + ": cannot be read");
    std::vector<std::tuple<std::string, std::string, size_t>> heads;
    for (std::string line; std::getline(file, line) && !line.empty();) {
      std::istringstream words(line);
      std::string name, kind;
      words >> name >> kind;
      size_t count = 1;
      for (size_t n; words >> n;) count *= n;
      heads.emplace_back(name, kind, count);
    }
    for (const auto& [name, kind, count] : heads) {
      void* room;
      if (kind == "f64") {
        room = reals_[name].emplace_back(count).data();
      } else {
        room = integers_[name].emplace_back(count).data();
      }
      file.read(static_cast<char*>(room), static_cast<std::streamsize>(8 * count));
      if (!file) fail(path + ": ends within " + name);
    }
  }

  bool has(const std::string& name) const { return reals_.count(name) > 0; }
  const std::vector<double>& real(const std::string& name) const { return found(reals_, name); }
  const std::vector<int64_t>& index(const std::string& name) const { return found(integers_, name); }
  double one(const std::string& name) const { return real(name).at(0); }

 private:
  template <typename T>
  using Named = std::map<std::string, std::vector<std::vector<T>>>;

  template <typename T>
  static const std::vector<T>& found(const Named<T>& all, const std::string& name) {
    const auto place = all.find(name);
    if (place == all.end()) fail("no column " + name);
    return place->second[0];
  }

  Named<double> reals_;
  Named<int64_t> integers_;
};

// Real columns to write, each with the length of its rows.
class Answer {
 public:
  void add(const std::string& name, size_t width, std::vector<double> values) {
    columns_.emplace_back(name, width, std::move(values));
  }

  void write(const std::string& path) const {
    std::ofstream file(path, std::ios::binary);
    for (const auto& [name, width, values] : columns_) {
      file << name << " f64 " << values.size() / width;
      if (width > 1) file << ' ' << width;
      file << '\n';
    }
    file << '\n';
    for (const auto& [name, width, values] : columns_) {
      file.write(reinterpret_cast<const char*>(values.data()),
                 static_cast<std::streamsize>(8 * values.size()));
    }
    if (!file) fail(path + ": cannot be written");
  }

 private:
  std::vector<std::tuple<std::string, size_t, std::vector<double>>> columns_;
};
