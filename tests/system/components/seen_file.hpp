// Writes the counts of a reader to a file, which a test reads.
#pragma once

#include <fstream>
#include <string>

#include "sample.hpp"

inline void write_seen(const std::string& file, const Seen& seen) {
  if (file.empty()) return;
  std::ofstream(file) << "{\"read\": " << seen.read << ", \"first\": " << seen.first
                      << ", \"last\": " << seen.last << ", \"gaps\": " << seen.gaps
                      << ", \"wrong\": " << seen.wrong << ", \"age_p50_us\": " << seen.age_us(0.5)
                      << ", \"age_p99_us\": " << seen.age_us(0.99) << ", \"oldest_ns\": " << seen.oldest_ns
                      << "}\n";
}
