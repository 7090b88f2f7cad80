// The limit beside which the engine is timed: ART with 96 weights on the paper's hopper, by hand.
//
// The scheme is that of `PredictorCorrector` and `Hopper`: one evaluation of the controller a tick,
// exact motion of the body, touchdown and lift-off located inside the tick. It records what a
// fitness needs at least: the height climbed in flight, the absolute work, and whether the leg
// broke. Numbers are the processor's own: reciprocals are estimates with one Newton step, so that
// last bits differ from processor to processor, which the engine's do not.
//
//     kernel LANES TICKS THREADS < weights > totals
//
// weights: float32, [96, lanes]; totals: float32, [3, lanes]. On stderr stand the seconds that
// passed and the seconds that cores were at work.

#include <immintrin.h>

#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <thread>
#include <vector>

#if defined(__AVX512F__)
constexpr int WIDTH = 16;
#else
constexpr int WIDTH = 8;
#endif

typedef float Vector __attribute__((vector_size(4 * WIDTH)));
typedef int Mask __attribute__((vector_size(4 * WIDTH)));

// The body (`Hopper`), the scenario and the sizes of the networks A', R and T.
constexpr float MASS = 0.1f, STIFFNESS = 5.0f, DAMPING = 0.2f, GRAVITY = 9.81f, LENGTH = 1.0f,
                MOST = 4.0f, OMEGA = 5.0f, RELEASE = 1.2f, TICK = 0.001f;
constexpr int ACTION = 7, REACTION = 9, ACTUATION = 8, WEIGHTS = 96;
constexpr float TWO_PI = 6.283185307179586f;

static inline Vector all(float x) { return Vector{} + x; }
static inline Vector most(Vector a, Vector b) { return a > b ? a : b; }
static inline Vector least(Vector a, Vector b) { return a < b ? a : b; }
static inline Vector size(Vector a) { return (Vector)((Mask)a & 0x7fffffff); }

#if defined(__AVX512F__)
static inline Vector round_of(Vector x) { return (Vector)_mm512_roundscale_ps((__m512)x, 0); }
static inline Vector floor_of(Vector x) { return (Vector)_mm512_roundscale_ps((__m512)x, 1); }
static inline Vector root(Vector x) { return (Vector)_mm512_sqrt_ps((__m512)x); }
static inline Vector estimate(Vector x) { return (Vector)_mm512_rcp14_ps((__m512)x); }
static inline Mask whole(Vector x) { return (Mask)_mm512_cvtps_epi32((__m512)x); }
static inline Vector scaled(Vector x, Vector n) {
  return (Vector)_mm512_scalef_ps((__m512)x, (__m512)n);
}
static inline bool any(Mask m) { return _mm512_test_epi32_mask((__m512i)m, (__m512i)m) != 0; }
#else
static inline Vector round_of(Vector x) { return (Vector)_mm256_round_ps((__m256)x, 0); }
static inline Vector floor_of(Vector x) { return (Vector)_mm256_round_ps((__m256)x, 1); }
static inline Vector root(Vector x) { return (Vector)_mm256_sqrt_ps((__m256)x); }
static inline Vector estimate(Vector x) { return (Vector)_mm256_rcp_ps((__m256)x); }
static inline Mask whole(Vector x) { return (Mask)_mm256_cvtps_epi32((__m256)x); }
static inline Vector scaled(Vector x, Vector n) { return (Vector)((Mask)x + (whole(n) << 23)); }
static inline bool any(Mask m) { return _mm256_movemask_ps((__m256)m) != 0; }
#endif

static inline Vector inverse(Vector x) {
  Vector guess = estimate(x);
  return guess * (2.0f - x * guess);
}

// Sine and cosine, as `tegotae.parts.maths.sin_cos`.
static inline void sin_cos(Vector angle, Vector &sine, Vector &cosine) {
  Vector quadrant = round_of(angle * (4.0f / TWO_PI));
  Vector r = (angle - quadrant * 1.5703125f) - quadrant * 4.83826794896e-4f, r2 = r * r;
  Vector s = r + r * r2 * (-1.0f / 6 + r2 * (1.0f / 120 + r2 * (-1.0f / 5040)));
  Vector c = 1.0f + r2 * (-0.5f + r2 * (1.0f / 24 + r2 * (-1.0f / 720 + r2 * (1.0f / 40320))));
  Mask n = whole(quadrant), swap = (n & 1) == 1;
  sine = (Vector)((Mask)(swap ? c : s) ^ ((n & 2) << 30));
  cosine = (Vector)((Mask)(swap ? s : c) ^ (((n + 1) & 2) << 30));
}

// 1 / (1 + 2^z), of which twice is 1 - tanh(x) at z = 2 x / ln 2; the weights are scaled to give z.
static inline Vector falling(Vector z) {
  z = least(z, all(40.0f));
#if !defined(__AVX512F__)
  z = most(z, all(-40.0f));
#endif
  Vector n = round_of(z), f = z - n;
  Vector power = 0.9999992614f + f * (0.6931218146f + f * (0.2402474483f + f * (0.05591786111f +
                 f * 0.009570102712f)));
  return inverse(1.0f + scaled(power, n));
}

// A network: its sum of output weights, less each times what its neuron falls short of 1. Weights
// of a neuron: those of its inputs and its bias, scaled, and that of its output.
template <int NEURONS, int INPUTS>
static inline Vector network(const Vector *w, Vector sum, const Vector *x) {
  Vector out = sum;
  for (int j = 0; j < NEURONS; j++, w += INPUTS + 2) {
    Vector z = w[INPUTS];
    for (int i = 0; i < INPUTS; i++) z += w[i] * x[i];
    out -= w[INPUTS + 1] * falling(z);
  }
  return out;
}

struct Law {  // of one contact mode: x'' = push - stiffness x - damping x'
  Vector push, stiffness, damping;
};

static inline Law law(Mask stance, Vector force) {
  return {(stance ? force * (1.0f / MASS) : Vector{}) - GRAVITY,
          stance ? all(STIFFNESS / MASS) : Vector{}, stance ? all(DAMPING / MASS) : Vector{}};
}

static inline void flow(const Law &l, Vector &x, Vector &v, Vector t) {  // a Taylor series
  Vector d[7] = {x, v, l.push - l.stiffness * x - l.damping * v};
  for (int n = 3; n < 7; n++) d[n] = -l.stiffness * d[n - 2] - l.damping * d[n - 1];
  Vector at = d[6], rate = d[6];
  for (int n = 6; n > 0; n--) at = d[n - 1] + t * (1.0f / n) * at;
  for (int n = 5; n > 0; n--) rate = d[n] + t * (1.0f / n) * rate;
  x = at, v = rate;
}

static Vector crossing(const Law &l, Vector x, Vector v) {  // as `frame.crossing_time`
  Vector a = l.push - l.stiffness * x - l.damping * v;
  Vector speed = root(most(v * v - 2.0f * a * x, Vector{}));
  Vector under = v + (x < 0.0f ? speed : -speed);
  Vector t = -2.0f * x / (under == 0.0f ? all(1.0f) : under);
  for (int step = 0; step < 2; step++) {
    t = least(most(t, Vector{}), all(TICK));
    Vector x_at = x, v_at = v;
    flow(l, x_at, v_at, t);
    t -= x_at / (v_at == 0.0f ? all(1.0f) : v_at);
  }
  return least(most(t, Vector{}), all(TICK));
}

static inline Vector rise(Vector x0, Vector v0, Vector x1, Vector v1, Vector t) {
  Mask turns = (v0 > 0.0f) != (v1 > 0.0f);
  Vector straight = most(x1 - x0, Vector{});
  if (!any(turns)) return straight;
  Vector fastest = most(v0, v1);
  return turns ? 0.5f * fastest * t * fastest / size(v1 - v0) : straight;
}

struct Propagator {  // of a whole tick of stance: exact, by the closed form in double precision
  float xx, xv, xp, vx, vv, vp;
};

static Propagator stance_tick() {
  double s = STIFFNESS / MASS, d = DAMPING / MASS, t = TICK;
  double decay = std::exp(-0.5 * d * t), w = std::sqrt(s - 0.25 * d * d);
  double c = std::cos(w * t), n = std::sin(w * t) / w;
  double xx = decay * (c + 0.5 * d * n), xv = decay * n;
  return {float(xx), float(xv), float((1 - xx) / s), float(-s * xv), float(decay * (c - 0.5 * d * n)),
          float(xv)};
}

struct Drive {  // the controller's output: force and rate
  Vector command, rate;
};

struct Weighed {  // the weights of a vector of lanes as the kernel wants them, and their sums
  Vector w[WEIGHTS], action, reaction, actuation;

  void scale(const float *from, int lanes, int at) {
    for (int i = 0; i < WEIGHTS; i++) __builtin_memcpy(&w[i], from + long(i) * lanes + at, sizeof(Vector));
    const float twice = 2.0f / 0.693147181f;
    action = scaled_network(w, ACTION, 2, twice);
    reaction = scaled_network(w + 28, REACTION, 1, twice);
    actuation = scaled_network(w + 56, ACTUATION, 3, twice);
  }
  static Vector scaled_network(Vector *w, int neurons, int inputs, float twice) {
    Vector sum{};
    for (int j = 0; j < neurons; j++, w += inputs + 2) {
      for (int i = 0; i <= inputs; i++) w[i] *= twice;
      sum += w[inputs + 1];
      w[inputs + 1] *= 2.0f;
    }
    return sum;
  }
};

static inline Drive drive(const Weighed &own, Vector phase, Vector x) {
  Vector s, c;
  sin_cos(phase, s, c);
  Vector load = most(-x, Vector{}) * (STIFFNESS / (MASS * GRAVITY));
  const Vector senses[2] = {s, c};
  Vector f = own.w[55] * network<ACTION, 2>(own.w, own.action, senses) *
             network<REACTION, 1>(own.w + 28, own.reaction, &load);
  const Vector all_of[3] = {s, c, f * std::sqrt(LENGTH / GRAVITY)};
  Vector force = network<ACTUATION, 3>(own.w + 56, own.actuation, all_of);
  return {least(most(force, Vector{}), all(MOST)), OMEGA + f};
}

static inline Vector adams_moulton(Vector earlier, Vector now, Vector then) {
  return (5.0f * then + 8.0f * now - earlier) * (1.0f / 12.0f);
}

struct Lanes {  // where a vector of lanes is; x is the height over touchdown
  Vector x, v, phase, climbed, work;
  Mask failed;
  Drive now, earlier;

  void start(const Weighed &own) {
    x = all(RELEASE - LENGTH), v = phase = climbed = work = Vector{};
    failed = Mask{};
    now = earlier = drive(own, phase, x);
  }

  inline void tick(const Weighed &own, const Propagator &p) {
    Mask stance = x < 0.0f;
    Law rough = law(stance, now.command);
    Vector a = rough.push - rough.stiffness * x - rough.damping * v;
    Vector guess = phase + TICK * (1.5f * now.rate - 0.5f * earlier.rate);
    Drive then = drive(own, guess, x + TICK * (v + 0.5f * TICK * a));
    Vector end = phase + TICK * adams_moulton(earlier.rate, now.rate, then.rate);
    Vector force = adams_moulton(earlier.command, now.command, then.command);
    force = least(most(force, Vector{}), all(MOST));

    Vector push = force * (1.0f / MASS) - GRAVITY;
    Vector x1 = stance ? p.xx * x + p.xv * v + p.xp * push
                       : x + TICK * v - 0.5f * TICK * TICK * GRAVITY;
    Vector v1 = stance ? p.vx * x + p.vv * v + p.vp * push : v - TICK * GRAVITY;
    Vector x_mid = x1, v_mid = v1, before = all(TICK);
    Mask crosses = (x1 < 0.0f) != stance;
    if (any(crosses)) {
      Law held = law(stance, force);
      Vector t = crosses ? crossing(held, x, v) : all(TICK), xa = x, va = v, xb{}, vb;
      flow(held, xa, va, t);
      vb = va;
      flow(law(~stance, force), xb, vb, TICK - t);
      before = t, x_mid = crosses ? Vector{} : x1, v_mid = crosses ? va : v1;
      x1 = crosses ? xb : x1, v1 = crosses ? vb : v1;
    }
    Vector flown = stance ? rise(x_mid, v_mid, x1, v1, TICK - before) : rise(x, v, x_mid, v_mid, before);
    Vector spent = size(force * (stance ? x_mid - x : x1 - x_mid));
    Mask sound = ~failed & (x1 > -LENGTH) & (size(end) < 1e30f);
    climbed += sound ? flown : Vector{};
    work += sound ? spent : Vector{};
    failed = ~sound;
    end -= TWO_PI * floor_of(end * (1.0f / TWO_PI));
    x = sound ? x1 : x, v = sound ? v1 : v, phase = sound ? end : phase;
    earlier = now, now = then;
  }
};

constexpr int TOGETHER = 2;  // vectors that advance side by side, for one waits on the other

static void run(const float *weights, float *totals, int lanes, int ticks, int first, int last) {
  const Propagator p = stance_tick();
  for (int at = first; at < last; at += TOGETHER * WIDTH) {
    alignas(64) Weighed own[TOGETHER];
    Lanes there[TOGETHER];
    for (int k = 0; k < TOGETHER; k++) {
      own[k].scale(weights, lanes, at + k * WIDTH);
      there[k].start(own[k]);
    }
    for (int tick = 0; tick < ticks; tick++)
      for (int k = 0; k < TOGETHER; k++) there[k].tick(own[k], p);
    for (int k = 0; k < TOGETHER; k++) {
      Vector out[3] = {there[k].climbed, there[k].work, there[k].failed ? all(1.0f) : Vector{}};
      for (int i = 0; i < 3; i++)
        __builtin_memcpy(totals + long(i) * lanes + at + k * WIDTH, &out[i], sizeof(Vector));
    }
  }
}

static double now_s(clockid_t clock) {
  timespec t;
  clock_gettime(clock, &t);
  return t.tv_sec + 1e-9 * t.tv_nsec;
}

int main(int, char **words) {
  const int lanes = atoi(words[1]), ticks = atoi(words[2]), threads = atoi(words[3]);
  const int block = TOGETHER * WIDTH;
  if (lanes % block) return fprintf(stderr, "lanes must be a multiple of %d\n", block), 2;
  std::vector<float> weights(long(WEIGHTS) * lanes), totals(3L * lanes);
  if (fread(weights.data(), 4, weights.size(), stdin) != weights.size()) return 1;
  const double begun = now_s(CLOCK_MONOTONIC), worked = now_s(CLOCK_PROCESS_CPUTIME_ID);
  std::vector<std::thread> at_work;
  for (int k = 0, blocks = lanes / block; k < threads; k++)
    at_work.emplace_back(run, weights.data(), totals.data(), lanes, ticks,
                         blocks * k / threads * block, blocks * (k + 1) / threads * block);
  for (auto &thread : at_work) thread.join();
  fprintf(stderr, "%g %g\n", now_s(CLOCK_MONOTONIC) - begun,
          now_s(CLOCK_PROCESS_CPUTIME_ID) - worked);
  fwrite(totals.data(), 4, totals.size(), stdout);
}
