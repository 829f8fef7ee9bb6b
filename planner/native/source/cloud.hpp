// Clouds from sensors: groups of samples, and a tree of balls over up to millions of small convex sets.
#pragma once

#include <array>
#include <cmath>
#include <cstring>
#include <numeric>
#include <vector>

#include "interrupts.hpp"
#include "solid.hpp"

namespace planner {

// Builds a solid from `count` convex sets, each the hull of `corners` points, rounded by `radius`.
//
// Sets are sorted along a Morton curve through their middles, with 21 bits per axis (Lauterbach and others 2009). A part is
// cut where the highest bit changes that its sets do not share, or in half. Equal sets stay in order, so the tree is the
// same on every machine. The part of n sets is the first of 2 n - 1 consecutive parts.
class CloudBuilder {
   public:
    Solid solid;

    CloudBuilder(const double* points, int count, int corners, double radius)
        : points_(points), whole_{0, 0, count}, radius_(radius) {
        solid.depth = infinity, solid.corners = corners, solid.parts.resize(2 * static_cast<size_t>(count) - 1);
        solid.kept.push_back(std::make_unique<double[]>(corners > 1 ? 3 * static_cast<size_t>(corners) * count : 0));
        sort_sets(count);
        const Box box = grow(whole_);
        double hull[24];
        for (int k = 0; k < 8; ++k) {
            hull[3 * k] = k & 1 ? box.high.x : box.low.x;
            hull[3 * k + 1] = k & 2 ? box.high.y : box.low.y, hull[3 * k + 2] = k & 4 ? box.high.z : box.low.z;
        }
        solid.hull = solid.keep(hull, 8, radius);
    }

    // Up to `most` boxes whose union holds the solid; the largest section is cut first.
    std::vector<Target> sections(int most) const {
        const auto size = [&](const Section& at) { return at.count > 1 ? solid.parts[at.part].size : 0.0; };
        std::vector<Section> made{whole_};
        while (static_cast<int>(made.size()) < most) {
            const auto largest = std::max_element(made.begin(), made.end(),
                                                  [&](const auto& a, const auto& b) { return size(a) < size(b); });
            if (largest->count == 1) break;
            const Section at = *largest;
            const int left = at.part + 1, right = solid.parts[at.part].right, count = (right - left + 1) / 2;
            *largest = {left, at.first, count};
            made.push_back({right, at.first + count, at.count - count});
        }
        std::vector<Target> targets;
        for (const Section& section : made) {
            Box box = box_of(keys_[section.first].set);
            for (int k = 1; k < section.count; ++k) box.add(box_of(keys_[section.first + k].set));
            targets.push_back({{Mat{}, -box.middle()}, box.half(), radius_, false});
        }
        return targets;
    }

   private:
    using Box = Solid::Box;
    struct Key {
        uint64_t code;
        int set;
    };
    // A part, and the keys of its sets.
    struct Section {
        int part, first, count;
    };

    const double* points_of(int set) const { return points_ + 3 * static_cast<size_t>(solid.corners) * set; }

    Box box_of(int set) const {
        Box box(points_of(set));
        for (int corner = 1; corner < solid.corners; ++corner) box.add(points_of(set) + 3 * corner);
        return box;
    }

    // Make the keys, sorted by their codes, 11 bits at a time.
    void sort_sets(int count) {
        Box all = box_of(0);
        for (int set = 1; set < count; ++set) all.add(box_of(set));
        const Vec size = all.high - all.low;
        const double longest = std::max(size.x, std::max(size.y, size.z)),
                     scale = longest > 0.0 ? 2097151.0 / longest : 0.0;
        keys_.resize(count);
        for (int set = 0; set < count; ++set) {
            const Vec at = scale * (box_of(set).middle() - all.low);
            keys_[set] = {spread_bits(at.x) << 2 | spread_bits(at.y) << 1 | spread_bits(at.z), set};
        }
        std::vector<Key> sorted(count);
        for (int shift = 0; shift < 63; shift += 11) {
            std::vector<int> begin(2049);
            for (const Key& key : keys_) ++begin[(key.code >> shift & 2047) + 1];
            std::partial_sum(begin.begin(), begin.end(), begin.begin());
            for (const Key& key : keys_) sorted[begin[key.code >> shift & 2047]++] = key;
            keys_.swap(sorted);
        }
    }

    // The 21 bits of a whole part, each followed by two zeros.
    static uint64_t spread_bits(double x) {
        uint64_t bits = static_cast<uint64_t>(x);
        bits = (bits | bits << 32) & 0x1F00000000FFFFu, bits = (bits | bits << 16) & 0x1F0000FF0000FFu;
        bits = (bits | bits << 8) & 0x100F00F00F00F00Fu, bits = (bits | bits << 4) & 0x10C30C30C30C30C3u;
        return (bits | bits << 2) & 0x1249249249249249u;
    }

    // How many sets of a section are in its first part.
    int cut(const Section& at) const {
        const Key *first = keys_.data() + at.first, *last = first + at.count;
        uint64_t other = first->code ^ last[-1].code;
        if (!other) return at.count / 2;
        for (int shift = 1; shift < 64; shift *= 2) other |= other >> shift;
        const uint64_t highest = other ^ other >> 1;
        return static_cast<int>(
            std::partition_point(first, last, [=](const Key& key) { return !(key.code & highest); }) - first);
    }

    // Make the parts of a section; return its box.
    Box grow(const Section& at) {
        poll_signal_at(at.part);
        Part& part = solid.parts[at.part];
        if (at.count > 1) {
            const int count = cut(at), left = at.part + 1, right = at.part + 2 * count;
            Box box = grow({left, at.first, count});
            box.add(grow({right, at.first + count, at.count - count}));
            part = box.ball(radius_), part.left = left, part.right = right;
            return box;
        }
        const int set = keys_[at.first].set, corners = solid.corners;
        const Box box = box_of(set);
        part = box.ball(radius_);
        double* place = solid.kept[0].get() + 3 * static_cast<size_t>(corners) * at.first;
        part.corners = corners > 1 ? Solid::by_axis(points_of(set), corners, place) : &part.middle.x;
        return box;
    }

    const double* points_;
    Section whole_;
    double radius_;
    std::vector<Key> keys_;
};

// Groups rows of three numbers: equal ones, or those in one cubic cell of `side` (m) if above 0. Groups are numbered in
// the order of their first rows.
class RowGroups {
   public:
    using Key = std::array<double, 3>;

    std::vector<int64_t> first, which;  // first row of each group, and the group of each row
    double spread = 0.0;                // m, largest distance of a row from the first of its group

    RowGroups(const double* rows, size_t count, double side) : which(count) {
        size_t size = 1;
        while (size < 2 * count) size *= 2;
        table_.assign(size, -1);
        for (size_t k = 0; k < count; ++k) {
            poll_signal_at(static_cast<int64_t>(k));
            Key key;
            for (int axis = 0; axis < 3; ++axis)  // -0.0 equals 0.0
                key[axis] = (side > 0.0 ? std::floor(rows[3 * k + axis] / side) : rows[3 * k + axis]) + 0.0;
            int32_t& group = table_[place_of(key)];
            if (group < 0) group = static_cast<int32_t>(keys_.size()), keys_.push_back(key), first.push_back(k);
            which[k] = group;
            spread = std::max(spread, square_between(rows, k, first[group]));
        }
        spread = std::sqrt(spread);
    }

    static double square_between(const double* rows, size_t a, size_t b) {
        const Vec apart = vec_at(rows + 3 * a) - vec_at(rows + 3 * b);
        return dot(apart, apart);
    }

    const Key& cell(size_t group) const { return keys_[group]; }
    // The group in a cell, or -1.
    int find(const Key& cell) const { return table_[place_of(cell)]; }

   private:
    size_t place_of(const Key& key) const {
        uint64_t hash = 0;
        for (const double x : key) {
            uint64_t bits;
            std::memcpy(&bits, &x, sizeof bits);
            hash = (hash ^ bits) * 0x9E3779B97F4A7C15u;
            hash ^= hash >> 29;
        }
        const size_t mask = table_.size() - 1;
        size_t at = hash & mask;
        while (table_[at] >= 0 && keys_[table_[at]] != key) at = (at + 1) & mask;
        return at;
    }

    std::vector<int32_t> table_;
    std::vector<Key> keys_;
};

// The first point of every connected component of balls of `radius`, or of more sections: those in a cell whose diagonal
// is their diameter touch, and of other cells only the first points are compared.
inline std::vector<int64_t> first_of_components(const double* points, size_t count, double radius) {
    const RowGroups cells(points, count, 2.0 * radius / std::sqrt(3.0));
    const int n = static_cast<int>(cells.first.size());
    std::vector<int> parent(n), size(n, 1);
    std::iota(parent.begin(), parent.end(), 0);
    const auto root = [&](int k) {
        while (parent[k] != k) k = parent[k] = parent[parent[k]];
        return k;
    };
    const auto connect = [&](int k, int reach, bool both_ways) {
        for (int x = both_ways ? -reach : 0; x <= reach; ++x)
            for (int y = -reach; y <= reach; ++y)
                for (int z = -reach; z <= reach; ++z) {
                    const RowGroups::Key& cell = cells.cell(k);
                    const int other = cells.find({cell[0] + x, cell[1] + y, cell[2] + z});
                    if (other < 0) continue;
                    const int a = std::min(root(k), root(other)), b = std::max(root(k), root(other));
                    const double apart = RowGroups::square_between(points, cells.first[k], cells.first[other]);
                    if (a != b && apart <= 4.0 * radius * radius) parent[b] = a, size[a] += size[b];
                }
    };
    for (int k = 0; k < n; ++k) poll_signal_at(k), connect(k, 1, false);
    // neighbours join nearly all; the others look farther
    const int largest = static_cast<int>(std::max_element(size.begin(), size.end()) - size.begin());
    for (int k = 0; k < n; ++k)
        if (root(k) != root(largest)) poll_signal_at(k), connect(k, 2, true);
    std::vector<int64_t> found;
    for (int k = 0; k < n; ++k)
        if (parent[k] == k) found.push_back(cells.first[k]);
    return found;
}

}  // namespace planner
