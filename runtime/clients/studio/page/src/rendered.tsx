import { useEffect, useState } from 'react';

import { useLoaded } from './load';
import { fetchRaster, PanZoom, Picture } from './raster';
import { noWebGL } from './solids';
import type { OutputValue } from './types';

// A picture of a solid that the server renders, for browsers without WebGL.
export function RenderedView({ value, shapes }: { value: OutputValue; shapes?: OutputValue | null }) {
  const [azimuth, setAzimuth] = useState(-41), [asked, setAsked] = useState(azimuth);
  // A picture takes a second, so a slider that moves asks for none.
  useEffect(() => {
    const timer = setTimeout(() => setAsked(azimuth), 250);
    return () => clearTimeout(timer);
  }, [azimuth]);
  const { data, error } = useLoaded(`${value.hash}.${shapes?.hash}.${asked}`, () => fetchRaster(value.hash, `picture&shapes=${shapes?.hash ?? ''}&azimuth=${asked}`, 0));
  return (
    <figure className="rendered">
      {data ? <PanZoom width={data.width} height={data.height} smooth><Picture raster={data} /></PanZoom> : <p className="none">{error || 'The program renders a picture…'}</p>}
      <figcaption className="options"><span>{noWebGL}</span>
        <label>Turn <input type="range" min={-180} max={180} value={azimuth} onChange={e => setAzimuth(Number(e.target.value))} aria-valuetext={`${azimuth} degrees`} /></label></figcaption>
    </figure>
  );
}
