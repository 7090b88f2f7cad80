// The spectrum of a height and its highest peak: `tegotae.measures.hopping.spectrum`.

// Power of the Hann-windowed signal less its mean, padded to four times its length and more.
export function spectrum(signal, sampleS) {
  const n = signal.length;
  const padded = 2 ** Math.ceil(Math.log2(4 * n));
  let mean = 0;
  for (const y of signal) mean += y / n;
  const [re, im] = [new Float64Array(padded), new Float64Array(padded)];
  signal.forEach((y, i) => (re[i] = (0.5 - 0.5 * Math.cos((2 * Math.PI * i) / n)) * (y - mean)));
  transform(re, im);
  const power = Float64Array.from({ length: padded / 2 + 1 }, (_, k) => re[k] ** 2 + im[k] ** 2);
  return { power, bin: (2 * Math.PI) / (padded * sampleS), resolution: (2 * Math.PI) / (n * sampleS) };
}

// Frequency of the highest peak [rad/s], refined by a parabola through the logarithm of three bins,
// and the square root of the share of the power in its main lobe.
export function peak({ power, bin, resolution }, lobeBins) {
  let at = 1;
  for (let k = 1; k < power.length - 1; k++) if (power[k] > power[at]) at = k;
  const [left, centre, right] = [-1, 0, 1].map((step) => Math.log(power[at + step] + 1e-30));
  const curvature = left - 2 * centre + right;
  const shift = curvature < 0 ? Math.max(-0.5, Math.min(0.5, (0.5 * (left - right)) / curvature)) : 0;
  const frequency = (at + shift) * bin;
  let [total, lobe] = [0, 0];
  power.forEach((p, k) => {
    total += p;
    if (Math.abs(k * bin - frequency) <= lobeBins * resolution) lobe += p;
  });
  return { frequency, share: Math.sqrt(lobe / (total > 0 ? total : 1)) };
}

// Fourier's transform in place, of a length that is a power of two.
function transform(re, im) {
  const n = re.length;
  for (let i = 1, j = 0; i < n; i++) {
    let bit = n >> 1;
    for (; j & bit; bit >>= 1) j ^= bit;
    j ^= bit;
    if (i < j) {
      [re[i], re[j]] = [re[j], re[i]];
      [im[i], im[j]] = [im[j], im[i]];
    }
  }
  for (let size = 2; size <= n; size *= 2) {
    for (let k = 0; k < size / 2; k++) {
      const [c, s] = [Math.cos((2 * Math.PI * k) / size), -Math.sin((2 * Math.PI * k) / size)];
      for (let low = k; low < n; low += size) {
        const high = low + size / 2;
        const [x, y] = [re[high] * c - im[high] * s, re[high] * s + im[high] * c];
        [re[high], im[high]] = [re[low] - x, im[low] - y];
        [re[low], im[low]] = [re[low] + x, im[low] + y];
      }
    }
  }
}
