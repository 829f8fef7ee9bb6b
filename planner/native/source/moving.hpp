// Obstacles that move by themselves along a known motion.
#pragma once

#include <algorithm>
#include <vector>

#include "vector.hpp"

namespace planner {

// Poses at times: between two of them the origin runs along a line and the frame turns about one axis, both evenly;
// before the first and after the last it stands still.
struct Motion {
    struct Stretch {
        double begin, end;  // s
        Frame from;
        Vec velocity;       // m/s
        Vec axis;           // in the frame's own coordinates
        double turning;     // rad/s
        double speed;       // m/s that no point of the obstacle exceeds
    };
    std::vector<Stretch> stretches;
    Frame last;

    Frame at(double t) const {
        if (stretches.empty()) return last;
        if (t >= stretches.back().end) return last;
        const Stretch* here = &stretches.front();
        for (const Stretch& stretch : stretches)
            if (t >= stretch.begin) here = &stretch;
        const double since = std::max(0.0, t - here->begin);
        return {here->from.turn * about(here->axis, here->turning * since), here->from.shift + since * here->velocity};
    }

    // The largest speed (m/s) of any point in [low, high] s.
    double fastest(double low, double high) const {
        double most = 0.0;
        for (const Stretch& stretch : stretches)
            if (!(stretch.begin > high || low > stretch.end)) most = std::max(most, stretch.speed);
        return most;
    }

   private:
    // Rodrigues' formula.
    static Mat about(Vec axis, double angle) {
        double sine, versine;
        sines_and_versines(&angle, 1, &sine, &versine);
        Mat cross, turn;
        const double entries[9] = {0, -axis.z, axis.y, axis.z, 0, -axis.x, -axis.y, axis.x, 0};
        std::copy(entries, entries + 9, cross.m);
        const Mat square = cross * cross;
        for (int k = 0; k < 9; ++k) turn.m[k] += sine * cross.m[k] + versine * square.m[k];
        return turn;
    }
};

}  // namespace planner
